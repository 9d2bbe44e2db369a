// What interpolate, vectors and fair share: the weights of the Laplacian and the bi-Laplacian.
#pragma once

#include <vector>

namespace beltrami {

/// {gamma_1, gamma_2}, for a PdeOperator. Throws InputError where both are 0.
std::vector<double> term_weights(double laplacian, double bilaplacian);

}  // namespace beltrami
