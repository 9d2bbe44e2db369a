// OBJ and OFF: numbers with as many digits as bring the same double back.
#include <fmt/format.h>

#include <iterator>
#include <ostream>
#include <string>

#include "beltrami/framework/formats/writers.hpp"

namespace beltrami::formats {

namespace {

/// Collects text and hands it on in large pieces.
class TextSink {
  public:
    explicit TextSink(std::ostream& stream) : stream_(stream) {}
    TextSink(const TextSink&) = delete;
    TextSink& operator=(const TextSink&) = delete;
    ~TextSink() { flush(); }

    template <class... Values>
    void add(fmt::format_string<Values...> format, Values&&... values) {
        fmt::format_to(std::back_inserter(text_), format, std::forward<Values>(values)...);
        if (text_.size() > 1U << 16U) flush();
    }

  private:
    void flush() {
        stream_.write(text_.data(), static_cast<std::streamsize>(text_.size()));
        text_.clear();
    }

    std::ostream& stream_;
    fmt::memory_buffer text_;
};

}  // namespace

bool is_color(const Field& field) {
    return field.name == "color" && field.values.cols() == 3;
}

void write_obj(std::ostream& stream, const Mesh& mesh, const Fields& fields) {
    const Field* color = nullptr;
    for (const Field& field : fields) {
        if (is_color(field)) color = &field;
    }
    TextSink sink(stream);
    const Points& p = mesh.points();
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
        sink.add("v {} {} {}", p(v, 0), p(v, 1), p(v, 2));
        if (color != nullptr) {
            sink.add(" {} {} {}", color->values(v, 0), color->values(v, 1), color->values(v, 2));
        }
        sink.add("\n");
    }
    const char* statement = mesh.kind() == CellKind::segment ? "l" : "f";
    for (Index c = 0; c < mesh.cell_count(); ++c) {
        sink.add("{}", statement);
        for (Eigen::Index k = 0; k < mesh.cells().cols(); ++k)
            sink.add(" {}", mesh.cells()(c, k) + 1);
        sink.add("\n");
    }
}

void write_off(std::ostream& stream, const Mesh& mesh, const Fields&) {
    TextSink sink(stream);
    sink.add("OFF\n{} {} 0\n", mesh.vertex_count(), mesh.cell_count());
    const Points& p = mesh.points();
    for (Index v = 0; v < mesh.vertex_count(); ++v)
        sink.add("{} {} {}\n", p(v, 0), p(v, 1), p(v, 2));
    for (Index c = 0; c < mesh.cell_count(); ++c) {
        sink.add("3 {} {} {}\n", mesh.cells()(c, 0), mesh.cells()(c, 1), mesh.cells()(c, 2));
    }
}

}  // namespace beltrami::formats
