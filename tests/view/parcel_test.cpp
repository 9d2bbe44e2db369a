// Numbers to the page and back, as page/src/protocol.ts reads them.

#include "view/parcel.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

namespace beltrami::view {
namespace {

struct Read {
    nlohmann::json header;
    std::string arrays;

    template <class Number>
    [[nodiscard]] std::vector<Number> array(const std::string& name) const {
        const nlohmann::json& place = header.at("arrays").at(name);
        EXPECT_EQ(place.at("type"), (std::is_same_v<Number, float> ? "f32" : "u32"));
        const auto at = place.at("at").get<std::size_t>();
        std::vector<Number> numbers(place.at("count").get<std::size_t>());
        EXPECT_EQ(at % 4, 0U);
        EXPECT_LE(at + 4 * numbers.size(), arrays.size());
        if (!numbers.empty()) std::memcpy(numbers.data(), arrays.data() + at, 4 * numbers.size());
        return numbers;
    }
};

Read read(const std::string& bytes) {
    std::uint32_t length = 0;
    EXPECT_GE(bytes.size(), sizeof length);
    std::memcpy(&length, bytes.data(), sizeof length);
    EXPECT_EQ(length % 4, 0U);
    EXPECT_LE(4 + length, bytes.size());
    return {nlohmann::json::parse(bytes.substr(4, length)), bytes.substr(4 + length)};
}

TEST(Parcel, ComesBackAsItWas) {
    Parcel parcel({{"kind", "frame"}, {"seconds", 0.25}});
    parcel.add("block", Block{{1.0, 2.0, 3.0}, {4.0, 5.0, 6.0}});
    parcel.add("points", Points{{0.5, 0.25, -1.0}});
    parcel.add("vector", Vector{{7.0, 8.0}});
    parcel.add("cells", Cells{{0, 1, 2}, {2, 1, 2147483647}});
    parcel.add("floats", std::vector<float>{9.5F});
    parcel.add("numbers", std::vector<Index>{3, 1});
    const Read back = read(parcel.bytes());
    EXPECT_EQ(back.header["kind"], "frame");
    EXPECT_EQ(back.header["seconds"], 0.25);
    EXPECT_EQ(back.array<float>("block"), (std::vector<float>{1, 2, 3, 4, 5, 6}));
    EXPECT_EQ(back.array<float>("points"), (std::vector<float>{0.5F, 0.25F, -1.0F}));
    EXPECT_EQ(back.array<float>("vector"), (std::vector<float>{7, 8}));
    EXPECT_EQ(back.array<std::uint32_t>("cells"), (std::vector<std::uint32_t>{0, 1, 2, 2, 1, 2147483647}));
    EXPECT_EQ(back.array<float>("floats"), std::vector<float>{9.5F});
    EXPECT_EQ(back.array<std::uint32_t>("numbers"), (std::vector<std::uint32_t>{3, 1}));
    EXPECT_EQ(floats_of(parcel.bytes(), "vector"), (std::vector<float>{7, 8}));
    EXPECT_EQ(back.arrays.size(), 4U * (6 + 3 + 2 + 6 + 1 + 2));
}

TEST(Parcel, ArraysAreAlignedWhateverTheHeader) {
    for (std::size_t length = 0; length < 8; ++length) {
        Parcel parcel(nlohmann::json{{"note", std::string(length, 'x')}});
        parcel.add("values", Vector{{1.0, 2.0}});
        const Read back = read(parcel.bytes());
        EXPECT_EQ(back.header["note"], std::string(length, 'x'));
        EXPECT_EQ(back.array<float>("values"), (std::vector<float>{1, 2}));
    }
}

// The page scales colours by the greatest value: an infinite one would leave none to see.
TEST(Parcel, ValuesBeyondFloatBecomeItsLargest) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    constexpr float most = std::numeric_limits<float>::max();
    Parcel parcel(nlohmann::json::object());
    parcel.add("values", Vector{{1e300, -1e300, infinity, -infinity, NAN, 1e-300, -0.0}});
    const std::vector<float> values = read(parcel.bytes()).array<float>("values");
    EXPECT_EQ(std::vector<float>(values.begin(), values.begin() + 4),
              (std::vector<float>{most, -most, most, -most}));
    EXPECT_TRUE(std::isnan(values[4]));
    EXPECT_EQ(values[5], 0.0F);
    EXPECT_TRUE(std::signbit(values[6]));
}

TEST(Parcel, MayBeEmpty) {
    EXPECT_EQ(read(Parcel(nlohmann::json::object()).bytes()).header["arrays"], nlohmann::json::object());
    Parcel parcel(nlohmann::json{{"kind", "frame"}});
    parcel.add("none", Block(0, 3));
    parcel.add("some", Vector{{1.0}});
    parcel.add("no cells", Cells(0, 3));
    const Read back = read(parcel.bytes());
    EXPECT_TRUE(back.array<float>("none").empty());
    EXPECT_EQ(back.array<float>("some"), std::vector<float>{1.0F});
    EXPECT_TRUE(back.array<std::uint32_t>("no cells").empty());
}

// File names are bytes: a browser takes UTF-8 only.
TEST(Parcel, TakesNamesThatAreNotUtf8) {
    Parcel parcel(nlohmann::json{{"name", "mesh-\xff\xc3.obj"}});
    parcel.add("field \xe9", Vector{{1.0}});
    const Read back = read(parcel.bytes());
    EXPECT_EQ(back.header["name"], "mesh-\uFFFD\uFFFD.obj");
    EXPECT_EQ(back.array<float>("field \uFFFD"), std::vector<float>{1.0F});
}

}  // namespace
}  // namespace beltrami::view
