// Room for many numbers that are written before they are read: on large pages, where the system has them, as a page
// fault for every 4 KB takes longer than what is computed there.
//
//     LargeArray panels(rows * columns);       // not set
//     panels.data()[0] = 1.0;
#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <memory>
#include <new>

namespace beltrami {

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
#ifdef __linux__
        if (alignment == large_page) madvise(data_.get(), bytes() / large_page * large_page, MADV_HUGEPAGE);
#endif
    }
    [[nodiscard]] double* data() const {
        return data_.get();
    }
    [[nodiscard]] std::size_t size() const {
        return size_;
    }
    [[nodiscard]] std::size_t bytes() const {
        return size_ * sizeof(double);
    }

  private:
    struct Freed {
        std::size_t alignment;
        void operator()(double* p) const { ::operator delete(p, std::align_val_t(alignment)); }
    };
    static constexpr std::size_t large_page = std::size_t{1} << 21;
    using Pointer = std::unique_ptr<double, Freed>;
    Pointer data_{nullptr, Freed{64}};
    std::size_t size_ = 0;
};

}  // namespace beltrami
