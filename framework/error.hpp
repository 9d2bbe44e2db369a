// The one family of exceptions. Each carries a sentence that says what is wrong and where and, but for a cancel, a hint
// that says what to do; the program prints both and exits with the family member's status.
#pragma once

#include <stdexcept>
#include <string>
#include <utility>

namespace beltrami {

class Error : public std::runtime_error {
  public:
    Error(const std::string& what, std::string hint, int exit_status)
        : std::runtime_error(what), hint_(std::move(hint)), exit_status_(exit_status) {}

    [[nodiscard]] const std::string& hint() const { return hint_; }
    [[nodiscard]] int exit_status() const { return exit_status_; }

  private:
    std::string hint_;
    int exit_status_;
};

/// Something the caller gave is unusable: a file, a vertex number, a time step. Exit status 2.
class InputError : public Error {
  public:
    InputError(const std::string& what, std::string hint) : Error(what, std::move(hint), 2) {}
};

/// A solve that did not reach its tolerance, or a factorization that broke down. Exit status 3.
class SolveError : public Error {
  public:
    SolveError(const std::string& what, std::string hint) : Error(what, std::move(hint), 3) {}
};

/// Somebody asked to stop. Exit status 130.
class Cancelled : public Error {
  public:
    explicit Cancelled(const std::string& what = "cancelled") : Error(what, {}, 130) {}
};

}  // namespace beltrami
