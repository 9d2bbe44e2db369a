// The user's browser, and Chromium without a window for pictures.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <string>

namespace beltrami::view {

/// A file in `folder` that leads to `url`. Programs are started with its name: command lines can be read by every user of
/// the machine, and the address holds the token.
std::filesystem::path write_door(const std::filesystem::path& folder, const std::string& url);

/// Opens the file with the desktop's browser; false where there is no desktop.
bool open_in_browser(const std::filesystem::path& door);

/// Chromium or Chrome without a window on a page, ended by the destructor.
class HeadlessBrowser {
  public:
    /// `folder`: of its own, for its profile. Throws InputError where none is installed.
    HeadlessBrowser(const std::filesystem::path& door, const std::filesystem::path& folder, int width,
                    int height);
    HeadlessBrowser(const HeadlessBrowser&) = delete;
    HeadlessBrowser& operator=(const HeadlessBrowser&) = delete;
    ~HeadlessBrowser();

    /// Throws as the constructor; for who asks before long work.
    static std::string find();

    /// False once it has ended.
    [[nodiscard]] bool running();

  private:
    pid_t process_ = -1;
};

}  // namespace beltrami::view
