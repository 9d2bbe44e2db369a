// Room for many numbers that are written before they are read: on large pages, where the system has them, as a page
// fault for every 4 KB takes longer than what is computed there.
//
//     LargeArray panels(rows * columns);       // not set
//     panels.data()[0] = 1.0;
#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <utility>

namespace beltrami {

constexpr std::size_t large_page = std::size_t{1} << 21;

/// Asks the system for large pages for such an array, before it is written; where there are none nothing happens.
inline void use_large_pages([[maybe_unused]] double* data, [[maybe_unused]] std::size_t size) {
#ifdef __linux__
    const auto address = reinterpret_cast<std::uintptr_t>(data);
    const std::uintptr_t first = (address + large_page - 1) / large_page * large_page;
    const std::uintptr_t last = (address + size * sizeof(double)) / large_page * large_page;
    // NOLINTNEXTLINE(performance-no-int-to-ptr): a page of the array
    if (first < last) madvise(reinterpret_cast<void*>(first), last - first, MADV_HUGEPAGE);
#endif
}

/// Begins on a cache line.
class LargeArray {
  public:
    LargeArray() = default;
    /// Throws std::bad_alloc.
    explicit LargeArray(std::size_t size) : size_(size) {
        if (size == 0) return;
        // Large pages hold nothing else.
        const std::size_t alignment = bytes() < large_page ? 64 : large_page;
        data_ = Pointer(static_cast<double*>(::operator new(bytes(), std::align_val_t(alignment))),
                        Freed{alignment});
        if (alignment == large_page) use_large_pages(data_.get(), size);
    }
    LargeArray(LargeArray&& other) noexcept
        : data_(std::move(other.data_)), size_(std::exchange(other.size_, 0)) {}
    LargeArray& operator=(LargeArray&& other) noexcept {
        data_ = std::move(other.data_);
        size_ = std::exchange(other.size_, 0);
        return *this;
    }
    ~LargeArray() = default;

    [[nodiscard]] double* data() const { return data_.get(); }
    [[nodiscard]] std::size_t size() const { return size_; }
    [[nodiscard]] std::size_t bytes() const { return size_ * sizeof(double); }

  private:
    struct Freed {
        std::size_t alignment;
        void operator()(double* p) const { ::operator delete(p, std::align_val_t(alignment)); }
    };
    using Pointer = std::unique_ptr<double, Freed>;
    Pointer data_{nullptr, Freed{64}};
    std::size_t size_ = 0;
};

}  // namespace beltrami
