#include "beltrami/apps/term_weights.hpp"

#include "beltrami/framework/error.hpp"

namespace beltrami {

std::vector<double> term_weights(double laplacian, double bilaplacian) {
    if (laplacian == 0.0 && bilaplacian == 0.0) {
        throw InputError("the coefficients of Laplacian and bi-Laplacian are both 0",
                         "give one of them a value");
    }
    return {laplacian, bilaplacian};
}

}  // namespace beltrami
