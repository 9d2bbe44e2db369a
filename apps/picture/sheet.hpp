// Paper for Cairo, which draws letters and thin lines and writes PNG.
#pragma once

#include <cairo.h>

#include <memory>
#include <string>

#include "beltrami/apps/picture/image.hpp"

namespace beltrami {

class Sheet {
  public:
    /// White. Throws InputError for sizes that Cairo cannot hold (more than 32767 pixels).
    Sheet(int width, int height);
    explicit Sheet(const Image& image);

    [[nodiscard]] cairo_t* cairo() const { return context_.get(); }
    [[nodiscard]] Image image() const;
    [[nodiscard]] std::string png() const;

    /// The font that everything is written in, at a size in pixels.
    void set_font(double size, bool bold = false);
    /// How wide a text is (pixels) from its start to where the next one would start.
    [[nodiscard]] double width_of(const std::string& text) const;
    /// Throws InputError for text that is not UTF-8. (x, y) is the left end of the line that the letters
    /// stand on.
    void write(double x, double y, const std::string& text);

  private:
    struct Destroy {
        void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
        void operator()(cairo_t* context) const { cairo_destroy(context); }
    };
    std::unique_ptr<cairo_surface_t, Destroy> surface_;
    std::unique_ptr<cairo_t, Destroy> context_;
};

}  // namespace beltrami
