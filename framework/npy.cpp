#include "beltrami/framework/npy.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <ostream>
#include <string>
#include <string_view>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/write_mesh.hpp"

namespace beltrami {

static_assert(std::endian::native == std::endian::little);

namespace {

constexpr std::string_view magic("\x93NUMPY\x01\x00", 8);
constexpr std::size_t alignment = 64;

void write_array(const std::filesystem::path& path, const Block& values, NpyType type,
                 const std::string& shape) {
    if (!values.allFinite()) {
        throw InputError(path.string() + ": an array has a value that is not a finite number",
                         "the computation that made it went wrong");
    }
    std::string header = fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': ({}), }}",
                                     type == NpyType::float64 ? "<f8" : "<f4", shape);
    const std::size_t length = magic.size() + 2 + header.size() + 1;
    header.append((alignment - length % alignment) % alignment, ' ');
    header += '\n';
    write_whole(path, [&](std::ostream& stream) {
        stream.write(magic.data(), static_cast<std::streamsize>(magic.size()));
        const auto size = static_cast<std::uint16_t>(header.size());
        stream.write(reinterpret_cast<const char*>(&size), 2);
        stream.write(header.data(), static_cast<std::streamsize>(header.size()));
        Eigen::RowVectorXf single;
        Eigen::RowVectorXd row;
        for (Eigen::Index i = 0; i < values.rows(); ++i) {
            const char* bytes = nullptr;
            std::size_t count = 0;
            if (type == NpyType::float32) {
                single = values.row(i).cast<float>();
                bytes = reinterpret_cast<const char*>(single.data());
                count = sizeof(float);
            } else {
                row = values.row(i);
                bytes = reinterpret_cast<const char*>(row.data());
                count = sizeof(double);
            }
            stream.write(bytes,
                         static_cast<std::streamsize>(count * static_cast<std::size_t>(values.cols())));
        }
    });
}

// An open file that closes itself.
class Descriptor {
  public:
    explicit Descriptor(const std::filesystem::path& path)
        : number_(::open(path.c_str(), O_RDONLY | O_CLOEXEC)) {}
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    ~Descriptor() {
        if (number_ >= 0) ::close(number_);
    }
    [[nodiscard]] int number() const { return number_; }

  private:
    int number_;
};

}  // namespace

void write_npy(const std::filesystem::path& path, const Block& values, NpyType type) {
    write_array(path, values, type, fmt::format("{}, {}", values.rows(), values.cols()));
}

void write_npy(const std::filesystem::path& path, const Vector& values) {
    write_array(path, Block(values), NpyType::float64, fmt::format("{},", values.size()));
}

NpyArray::NpyArray(const std::filesystem::path& path) {
    const auto fail = [&](const std::string& what) {
        throw InputError(fmt::format("{}: {}", path.string(), what),
                         "the folder is damaged: make it anew, or restore the file");
    };
    const Descriptor file(path);
    struct stat status {};
    if (file.number() < 0 || ::fstat(file.number(), &status) != 0 || !S_ISREG(status.st_mode))
        fail("the file cannot be read");
    const auto size = static_cast<std::size_t>(status.st_size);
    if (size < magic.size() + 2) fail("the file is cut off");
    void* const address = ::mmap(nullptr, size, PROT_READ, MAP_SHARED, file.number(), 0);
    if (address == MAP_FAILED) fail("the file cannot be mapped into memory");
    mapping_ =
        std::shared_ptr<const void>(address, [size](const void* p) { ::munmap(const_cast<void*>(p), size); });
    const auto* const bytes = static_cast<const char*>(address);
    if (std::string_view(bytes, magic.size()) != magic) fail("not an array of NumPy's format 1.0");
    const std::size_t header_size = static_cast<unsigned char>(bytes[magic.size()]) +
                                    256U * static_cast<unsigned char>(bytes[magic.size() + 1]);
    const std::size_t start = magic.size() + 2 + header_size;
    if (size < start) fail("the file is cut off");
    const std::string_view header(bytes + magic.size() + 2, header_size);
    if (header.find("'<f8'") != std::string_view::npos) {
        type_ = NpyType::float64;
    } else if (header.find("'<f4'") != std::string_view::npos) {
        type_ = NpyType::float32;
    } else {
        fail("its numbers are neither float64 nor float32");
    }
    if (header.find("'fortran_order': False") == std::string_view::npos) fail("it is not in C order");
    const auto shape = header.find("'shape': (");
    if (shape == std::string_view::npos) fail("its shape is not given");
    std::string_view text = header.substr(shape + 10);
    text = text.substr(0, text.find(')'));
    std::vector<Eigen::Index> sizes;
    while (!text.empty()) {
        text.remove_prefix(std::min(text.find_first_not_of(", "), text.size()));
        Eigen::Index number = 0;
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
        if (error != std::errc()) break;
        sizes.push_back(number);
        text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    }
    if (sizes.empty() || sizes.size() > 2 || *std::min_element(sizes.begin(), sizes.end()) < 0)
        fail("it is not of one or two dimensions");
    rows_ = sizes[0];
    columns_ = sizes.size() == 2 ? sizes[1] : 1;
    const std::size_t width = type_ == NpyType::float64 ? sizeof(double) : sizeof(float);
    if (size - start != width * static_cast<std::size_t>(rows_) * static_cast<std::size_t>(columns_))
        fail(fmt::format("it holds {} bytes, which is not {} x {} numbers", size - start, rows_, columns_));
    data_ = reinterpret_cast<const std::byte*>(bytes + start);
}

Block NpyArray::values() const {
    using Floats = BlockOf<float>;
    if (type_ == NpyType::float32)
        return Eigen::Map<const Floats>(row<float>(0), rows_, columns_).cast<double>();
    return Eigen::Map<const Block>(row<double>(0), rows_, columns_);
}

}  // namespace beltrami
