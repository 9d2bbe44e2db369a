#include "beltrami/framework/npy.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "beltrami/framework/error.hpp"
#include "meshes.hpp"

namespace beltrami {
namespace {

using testing::bytes_of;
using testing::Scratch;

Block some_values() {
    Block values(3, 5);
    for (Eigen::Index i = 0; i < values.size(); ++i)
        values.data()[i] = 0.1 * static_cast<double>(i) - 1.0 / 3.0;
    return values;
}

TEST(Npy, ComesBackToTheLastBit) {
    const Scratch folder;
    const Block values = some_values();
    write_npy(folder / "a.npy", values);
    const NpyArray array(folder / "a.npy");
    EXPECT_EQ(array.type(), NpyType::float64);
    EXPECT_EQ(array.rows(), 3);
    EXPECT_EQ(array.columns(), 5);
    EXPECT_EQ(array.values(), values);
    EXPECT_EQ(array.row<double>(2)[4], values(2, 4));
}

TEST(Npy, FloatsAreRounded) {
    const Scratch folder;
    write_npy(folder / "a.npy", some_values(), NpyType::float32);
    const NpyArray array(folder / "a.npy");
    EXPECT_EQ(array.type(), NpyType::float32);
    EXPECT_EQ(array.values(), some_values().cast<float>().cast<double>().eval());
    EXPECT_NE(array.values(), some_values());
}

// What numpy.save writes for these, by the format's description: magic, version 1.0, a header padded to 64 bytes.
TEST(Npy, IsNumPysFormat) {
    const Scratch folder;
    write_npy(folder / "a.npy", Vector(Vector::LinSpaced(4, 0.0, 3.0)));
    const std::string bytes = bytes_of(folder / "a.npy");
    ASSERT_EQ(bytes.size(), 128u + 32u);
    EXPECT_EQ(bytes.substr(0, 8), std::string("\x93NUMPY\x01\x00", 8));
    EXPECT_EQ(static_cast<unsigned char>(bytes[8]), 118);
    const std::string header = "{'descr': '<f8', 'fortran_order': False, 'shape': (4,), }";
    EXPECT_EQ(bytes.substr(10, header.size()), header);
    EXPECT_EQ(bytes[127], '\n');
    EXPECT_EQ(NpyArray(folder / "a.npy").columns(), 1);
}

TEST(Npy, RefusesWhatIsDamaged) {
    const Scratch folder;
    EXPECT_THROW(NpyArray(folder / "none.npy"), InputError);
    write_npy(folder / "a.npy", some_values());
    const std::string whole = bytes_of(folder / "a.npy");
    const auto refused = [&](const std::string& bytes) {
        std::ofstream(folder / "b.npy", std::ios::binary) << bytes;
        EXPECT_THROW(NpyArray(folder / "b.npy"), InputError) << bytes.size() << " bytes";
    };
    for (const std::size_t size : {std::size_t{0}, std::size_t{5}, std::size_t{20}, whole.size() - 1})
        refused(whole.substr(0, size));
    refused(whole + "x");
    refused("no" + whole.substr(2));
    std::string other = whole;
    other.replace(other.find("<f8"), 3, "<i8");
    refused(other);
    other = whole;
    other.replace(other.find("False"), 5, "True ");
    refused(other);
    other = whole;
    other.replace(other.find("(3, 5)"), 6, "(3, 6)");
    refused(other);
}

TEST(Npy, WritesNoNaN) {
    const Scratch folder;
    Block values = some_values();
    values(1, 1) = NAN;
    EXPECT_THROW(write_npy(folder / "a.npy", values), InputError);
    EXPECT_FALSE(std::filesystem::exists(folder / "a.npy"));
}

}  // namespace
}  // namespace beltrami
