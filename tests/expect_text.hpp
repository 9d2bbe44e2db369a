// Texts in tests: all of some parts must be in one.
#pragma once

#include <gtest/gtest.h>

#include <initializer_list>
#include <string>

namespace beltrami::testing {

inline ::testing::AssertionResult contains(const std::string& text,
                                           std::initializer_list<std::string> parts) {
    for (const std::string& part : parts) {
        if (text.find(part) == std::string::npos) {
            return ::testing::AssertionFailure() << "\"" << text << "\"\nlacks \"" << part << "\"";
        }
    }
    return ::testing::AssertionSuccess();
}

}  // namespace beltrami::testing
