// NumPy's array files: numpy.load opens what is written here, and arrays are read where they lie in the file.
//
//     write_npy("eigenvalues.npy", values);
//     const NpyArray array("band-00000.npy");                  // mapped into memory, not read
//     array.rows();  array.columns();  array.row<double>(7);
//
// Little-endian float64 or float32, in C order, of one or two dimensions (format version 1.0).
#pragma once

#include <filesystem>
#include <memory>
#include <span>

#include "beltrami/framework/types.hpp"

namespace beltrami {

enum class NpyType { float64, float32 };

/// rows x columns, written whole or not at all. Throws InputError where the file cannot be written, and for a value that
/// is not finite, in which case nothing is written.
void write_npy(const std::filesystem::path& path, const Block& values, NpyType type = NpyType::float64);
/// One dimension.
void write_npy(const std::filesystem::path& path, const Vector& values);

/// The array of a file, mapped: pages are read when they are touched, and the system may drop them again.
class NpyArray {
  public:
    /// Throws InputError for a file that cannot be read, is not such an array, or is cut off.
    explicit NpyArray(const std::filesystem::path& path);

    [[nodiscard]] NpyType type() const { return type_; }
    [[nodiscard]] Eigen::Index rows() const { return rows_; }
    /// 1 for one dimension.
    [[nodiscard]] Eigen::Index columns() const { return columns_; }

    /// Row i, columns() values. Scalar must be that of type(): double or float.
    template <class Scalar>
    [[nodiscard]] const Scalar* row(Eigen::Index i) const {
        return reinterpret_cast<const Scalar*>(data_) + i * columns_;
    }

    /// All of it, as double.
    [[nodiscard]] Block values() const;

  private:
    std::shared_ptr<const void> mapping_;
    const std::byte* data_ = nullptr;
    NpyType type_ = NpyType::float64;
    Eigen::Index rows_ = 0;
    Eigen::Index columns_ = 0;
};

}  // namespace beltrami
