// A band's certificate as JSON, in the manifest of a stored basis and in the program's summaries: see docs/spectrum.md.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "beltrami/solvers/spectrum.hpp"

namespace beltrami {

void to_json(nlohmann::json& json, const BandCertificate& band);
/// Throws nlohmann::json::exception where an entry is missing or of another type.
void from_json(const nlohmann::json& json, BandCertificate& band);

}  // namespace beltrami
