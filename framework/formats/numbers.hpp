// Numbers stored as bytes.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <type_traits>
#include <vector>

namespace beltrami::formats {

enum class NumberType { int8, uint8, int16, uint16, int32, uint32, int64, uint64, float32, float64 };

/// Calls visit(T{}) with the C++ type.
template <class Visit>
decltype(auto) with_type(NumberType type, Visit&& visit) {
    switch (type) {
        case NumberType::int8:
            return visit(std::int8_t{});
        case NumberType::uint8:
            return visit(std::uint8_t{});
        case NumberType::int16:
            return visit(std::int16_t{});
        case NumberType::uint16:
            return visit(std::uint16_t{});
        case NumberType::int32:
            return visit(std::int32_t{});
        case NumberType::uint32:
            return visit(std::uint32_t{});
        case NumberType::int64:
            return visit(std::int64_t{});
        case NumberType::uint64:
            return visit(std::uint64_t{});
        case NumberType::float32:
            return visit(float{});
        case NumberType::float64:
            return visit(double{});
    }
    throw std::logic_error("with_type: no such type");
}

inline std::size_t byte_size(NumberType type) {
    return with_type(type, [](auto t) { return sizeof(t); });
}

template <class T>
T load(const char* bytes, std::endian order) {
    char held[sizeof(T)];
    if (order == std::endian::native) {
        std::memcpy(held, bytes, sizeof(T));
    } else {
        for (std::size_t i = 0; i < sizeof(T); ++i)
            held[i] = bytes[sizeof(T) - 1 - i];
    }
    return std::bit_cast<T>(held);
}

/// Exact to 2^53, and a number no vertex can have for what is not whole.
inline std::int64_t whole(double value) {
    constexpr double limit = 9007199254740992.0;
    const bool fits = value >= -limit && value <= limit;  // false for NaN
    if (!fits || static_cast<double>(static_cast<std::int64_t>(value)) != value) return INT64_MIN;
    return static_cast<std::int64_t>(value);
}

/// As double or std::int64_t.
template <class To, class From>
To convert(From value) {
    if constexpr (std::is_same_v<To, std::int64_t> && std::is_floating_point_v<From>) {
        return whole(static_cast<double>(value));
    } else {
        return static_cast<To>(value);
    }
}

template <class To>
To load_as(const char* bytes, NumberType type, std::endian order) {
    return with_type(type, [&](auto t) { return convert<To>(load<decltype(t)>(bytes, order)); });
}

/// All whole numbers of the type that `bytes` holds.
template <class To>
std::vector<To> load_all(std::string_view bytes, NumberType type, std::endian order) {
    return with_type(type, [&](auto t) {
        std::vector<To> values(bytes.size() / sizeof(t));
        for (std::size_t i = 0; i < values.size(); ++i) {
            values[i] = convert<To>(load<decltype(t)>(bytes.data() + i * sizeof(t), order));
        }
        return values;
    });
}

}  // namespace beltrami::formats
