#include "page.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <array>
#include <cstdint>
#include <numeric>
#include <stdexcept>

#include "beltrami/framework/error.hpp"

#ifdef BELTRAMI_PAGE
// cmake/Page.cmake puts the file between these.
extern "C" const char beltrami_page_begin[];  // NOLINT(readability-identifier-naming)
extern "C" const char beltrami_page_end[];    // NOLINT(readability-identifier-naming)
#endif

namespace beltrami::view {

namespace {

constexpr std::string_view marker = "<!--beltrami:data-->";

std::string_view bundle() {
#ifdef BELTRAMI_PAGE
    return {beltrami_page_begin, static_cast<std::size_t>(beltrami_page_end - beltrami_page_begin)};
#else
    return {};
#endif
}

std::string deflated(const std::string& bytes) {
    uLongf size = compressBound(bytes.size());
    std::string packed(size, '\0');
    // A higher level takes several times as long for numbers, which it makes no smaller.
    constexpr int level = 6;
    const int failed = compress2(reinterpret_cast<Bytef*>(packed.data()), &size,
                                 reinterpret_cast<const Bytef*>(bytes.data()), bytes.size(), level);
    if (failed != Z_OK) throw std::runtime_error(fmt::format("zlib cannot compress: {}", zError(failed)));
    packed.resize(size);
    return packed;
}

// RFC 4648, section 4.
void append_base64(std::string& text, std::string_view bytes) {
    constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const auto byte = [&](std::size_t i) -> std::uint32_t {
        return i < bytes.size() ? static_cast<unsigned char>(bytes[i]) : 0U;
    };
    text.reserve(text.size() + (bytes.size() + 2) / 3 * 4);
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        const std::uint32_t group = (byte(i) << 16U) | (byte(i + 1) << 8U) | byte(i + 2);
        text += digits[(group >> 18U) & 63U];
        text += digits[(group >> 12U) & 63U];
        text += i + 1 < bytes.size() ? digits[(group >> 6U) & 63U] : '=';
        text += i + 2 < bytes.size() ? digits[group & 63U] : '=';
    }
}

std::string escaped(std::string_view text) {
    std::string safe;
    for (const char c : text) {
        switch (c) {
            case '&':
                safe += "&amp;";
                break;
            case '<':
                safe += "&lt;";
                break;
            case '>':
                safe += "&gt;";
                break;
            default:
                safe += c;
        }
    }
    return safe;
}

// Where a part of the bundle is that build.mjs promises.
std::size_t place_of(std::string_view html, std::string_view part) {
    const std::size_t at = html.find(part);
    if (at == std::string_view::npos)
        throw std::logic_error(fmt::format("the page that was built in has no {}", part));
    return at;
}

}  // namespace

bool has_page() {
    return !bundle().empty();
}

void require_page(std::string_view wanted_by) {
    if (has_page()) return;
    throw InputError(fmt::format("{} needs the page, and this program was built without it", wanted_by),
                     "install Node and the page's packages with ./dev setup, then build again");
}

std::string live_page() {
    return std::string(bundle());
}

std::string embedded(const PageMessage& message) {
    std::string plain = message.is_parcel ? std::string("P\0\0\0", 4) : std::string("T");
    plain += message.bytes;
    std::string element = R"(<script class="beltrami-message" type="text/plain">)";
    append_base64(element, deflated(plain));
    element += "</script>\n";
    return element;
}

std::string self_contained_page(std::string_view title, const std::vector<std::string>& embedded_messages) {
    const std::string_view html = bundle();
    constexpr std::string_view title_begin = "<title>";
    const std::size_t title_at = place_of(html, title_begin) + title_begin.size();
    const std::size_t title_end = place_of(html, "</title>");
    const std::size_t data_at = place_of(html, marker);
    if (title_end < title_at || data_at < title_end)
        throw std::logic_error("the page that was built in has its data before its title");
    std::string page(html.substr(0, title_at));
    page.reserve(
        std::accumulate(embedded_messages.begin(), embedded_messages.end(), html.size() + 6 * title.size(),
                        [](std::size_t sum, const std::string& message) { return sum + message.size(); }));
    page += escaped(title);
    page += html.substr(title_end, data_at - title_end);
    for (const std::string& message : embedded_messages)
        page += message;
    page += html.substr(data_at + marker.size());
    return page;
}

}  // namespace beltrami::view
