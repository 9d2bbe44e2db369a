#include "parcel.hpp"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <limits>

namespace beltrami::view {

static_assert(std::endian::native == std::endian::little, "parcels are little-endian");

namespace {

template <class To, class Dense>
void append(std::string& bytes, const Dense& values) {
    const std::size_t start = bytes.size();
    bytes.resize(start + sizeof(To) * static_cast<std::size_t>(values.size()));
    char* at = bytes.data() + start;
    for (const auto value : values) {
        To number{};
        if constexpr (std::is_floating_point_v<To>) {
            constexpr double most = std::numeric_limits<float>::max();
            number = static_cast<To>(std::clamp<double>(value, -most, most));
        } else {
            number = static_cast<To>(value);
        }
        std::memcpy(at, &number, sizeof number);
        at += sizeof number;
    }
}

std::span<const double> numbers_of(const double* data, Eigen::Index size) {
    return {data, static_cast<std::size_t>(size)};
}

}  // namespace

void Parcel::place(const std::string& name, const char* type, std::size_t count) {
    header_["arrays"][name] = {{"type", type}, {"at", arrays_.size()}, {"count", count}};
}

void Parcel::add(const std::string& name, const Block& values) {
    place(name, "f32", static_cast<std::size_t>(values.size()));
    append<float>(arrays_, numbers_of(values.data(), values.size()));
}

void Parcel::add(const std::string& name, const Points& points) {
    place(name, "f32", static_cast<std::size_t>(points.size()));
    append<float>(arrays_, numbers_of(points.data(), points.size()));
}

void Parcel::add(const std::string& name, const Vector& values) {
    place(name, "f32", static_cast<std::size_t>(values.size()));
    append<float>(arrays_, numbers_of(values.data(), values.size()));
}

void Parcel::add(const std::string& name, std::span<const float> values) {
    place(name, "f32", values.size());
    append<float>(arrays_, values);
}

void Parcel::add(const std::string& name, const Cells& cells) {
    add(name, std::span<const Index>(cells.data(), static_cast<std::size_t>(cells.size())));
}

void Parcel::add(const std::string& name, std::span<const Index> numbers) {
    place(name, "u32", numbers.size());
    append<std::uint32_t>(arrays_, numbers);
}

std::string Parcel::bytes() const {
    nlohmann::json header = header_;
    if (!header.contains("arrays")) header["arrays"] = nlohmann::json::object();
    // dump() throws on a file name that is not UTF-8 unless told to replace it.
    std::string text = header.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    text.append((4 - text.size() % 4) % 4, ' ');
    std::string bytes(4, '\0');
    const auto length = static_cast<std::uint32_t>(text.size());
    std::memcpy(bytes.data(), &length, sizeof length);
    return bytes + text + arrays_;
}

std::vector<float> floats_of(std::string_view parcel, const std::string& name) {
    std::uint32_t length = 0;
    std::memcpy(&length, parcel.data(), sizeof length);
    const nlohmann::json header = nlohmann::json::parse(parcel.substr(sizeof length, length));
    const nlohmann::json& place = header.at("arrays").at(name);
    const std::string_view arrays = parcel.substr(sizeof length + length);
    std::vector<float> values(place.at("count").get<std::size_t>());
    if (!values.empty())
        std::memcpy(values.data(), arrays.data() + place.at("at").get<std::size_t>(),
                    values.size() * sizeof(float));
    return values;
}

}  // namespace beltrami::view
