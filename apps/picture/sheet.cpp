#include "beltrami/apps/picture/sheet.hpp"

#include <fmt/format.h>

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "beltrami/framework/error.hpp"

namespace beltrami {

namespace {

void check(cairo_status_t status, const std::string& what) {
    if (status == CAIRO_STATUS_SUCCESS) return;
    throw InputError(fmt::format("{}: {}", what, cairo_status_to_string(status)), "a smaller picture may do");
}

cairo_status_t append(void* text, const unsigned char* data, unsigned length) {
    static_cast<std::string*>(text)->append(reinterpret_cast<const char*>(data), length);
    return CAIRO_STATUS_SUCCESS;
}

}  // namespace

Sheet::Sheet(int width, int height)
    : surface_(cairo_image_surface_create(CAIRO_FORMAT_RGB24, width, height)) {
    if (cairo_surface_status(surface_.get()) != CAIRO_STATUS_SUCCESS) {
        throw InputError(fmt::format("a picture of {} x {} pixels cannot be made", width, height),
                         "give fewer pixels; at most 32767 are possible in both directions");
    }
    context_.reset(cairo_create(surface_.get()));
    cairo_set_source_rgb(cairo(), 1.0, 1.0, 1.0);
    cairo_paint(cairo());
    cairo_set_source_rgb(cairo(), 0.13, 0.13, 0.15);

    // Letters alike on every machine, whatever its users like on their screens.
    cairo_font_options_t* options = cairo_font_options_create();
    cairo_font_options_set_antialias(options, CAIRO_ANTIALIAS_GRAY);
    cairo_font_options_set_hint_style(options, CAIRO_HINT_STYLE_NONE);
    cairo_font_options_set_hint_metrics(options, CAIRO_HINT_METRICS_OFF);
    cairo_set_font_options(cairo(), options);
    cairo_font_options_destroy(options);
}

Sheet::Sheet(const Image& image) : Sheet(image.width, image.height) {
    cairo_surface_flush(surface_.get());
    unsigned char* data = cairo_image_surface_get_data(surface_.get());
    const std::ptrdiff_t stride = cairo_image_surface_get_stride(surface_.get());
    const std::uint8_t* from = image.rgb.data();
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x, from += 3) {
            const std::uint32_t pixel =
                (std::uint32_t{from[0]} << 16U) | (std::uint32_t{from[1]} << 8U) | from[2];
            std::memcpy(data + y * stride + 4 * static_cast<std::ptrdiff_t>(x), &pixel, sizeof pixel);
        }
    }
    cairo_surface_mark_dirty(surface_.get());
}

Image Sheet::image() const {
    cairo_surface_flush(surface_.get());
    Image image = blank_image(cairo_image_surface_get_width(surface_.get()),
                              cairo_image_surface_get_height(surface_.get()));
    const unsigned char* data = cairo_image_surface_get_data(surface_.get());
    const std::ptrdiff_t stride = cairo_image_surface_get_stride(surface_.get());
    std::uint8_t* to = image.rgb.data();
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x, to += 3) {
            std::uint32_t pixel = 0;
            std::memcpy(&pixel, data + y * stride + 4 * static_cast<std::ptrdiff_t>(x), sizeof pixel);
            to[0] = static_cast<std::uint8_t>(pixel >> 16U);
            to[1] = static_cast<std::uint8_t>(pixel >> 8U);
            to[2] = static_cast<std::uint8_t>(pixel);
        }
    }
    return image;
}

std::string Sheet::png() const {
    std::string bytes;
    check(cairo_surface_write_to_png_stream(surface_.get(), append, &bytes), "the picture cannot be encoded");
    return bytes;
}

void Sheet::set_font(double size, bool bold) {
    cairo_select_font_face(cairo(), "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL,
                           bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_font_size(cairo(), size);
}

double Sheet::width_of(const std::string& text) const {
    cairo_text_extents_t extents;
    cairo_text_extents(cairo(), text.c_str(), &extents);
    return extents.x_advance;
}

void Sheet::write(double x, double y, const std::string& text) {
    cairo_move_to(cairo(), x, y);
    cairo_show_text(cairo(), text.c_str());
    check(cairo_status(cairo()), "this text cannot be drawn");
}

}  // namespace beltrami
