#include "beltrami/solvers/band_json.hpp"

#include <nlohmann/json.hpp>

namespace beltrami {

void to_json(nlohmann::json& json, const BandCertificate& band) {
    json = {{"lower", band.lower.value},
            {"upper", band.upper.value},
            {"inertia_lower", band.lower.below},
            {"inertia_upper", band.upper.below},
            {"found", band.found},
            {"count", band.kept},
            {"max_residual", band.max_residual},
            {"max_orthogonality_error", band.max_orthogonality_error},
            {"shift", band.shift},
            {"dimension", band.dimension},
            {"rounds", band.rounds}};
}

void from_json(const nlohmann::json& json, BandCertificate& band) {
    band.lower = {json.at("lower"), json.at("inertia_lower")};
    band.upper = {json.at("upper"), json.at("inertia_upper")};
    band.found = json.at("found");
    band.kept = json.at("count");
    band.max_residual = json.at("max_residual");
    band.max_orthogonality_error = json.at("max_orthogonality_error");
    band.shift = json.at("shift");
    band.dimension = json.at("dimension");
    band.rounds = json.at("rounds");
}

}  // namespace beltrami
