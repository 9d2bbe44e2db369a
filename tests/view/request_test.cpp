// What a page asks for is read, or refused with a sentence.

#include "view/request.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "beltrami/framework/error.hpp"

namespace beltrami::view {
namespace {

const std::vector<std::string> words = {"ply", "obj"};

Request with(const std::string& value) {
    return Request(R"({"do":"test","x":)" + value + "}");
}

// A sentence that names the key, and a hint.
template <class Reading>
void expect_refused(const std::string& value, Reading reading) {
    const Request request = with(value);
    try {
        reading(request);
        ADD_FAILURE() << value << " was taken";
    } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find("'x'"), std::string::npos) << error.what();
        EXPECT_FALSE(error.hint().empty());
    }
}

TEST(Request, SaysWhatToDo) {
    EXPECT_EQ(Request(R"({"do":"heat.source"})").name(), "heat.source");
    EXPECT_EQ(Request(R"({"do":"run"})").id(), 0);
    EXPECT_EQ(Request(R"({"do":"run","id":1000000000000})").id(), 1000000000000);
    for (const std::string text :
         {"", " ", "null", "true", "3", "[]", "\"run\"", "{", "{}", "{\"do\"}", "{\"do\":3}", "{\"do\":null}",
          "{'do':'run'}", "{\"do\":\"run\"} x", "{\"do\":\"\xff\"}", R"({"do":"run","id":"3"})",
          R"({"do":"run","id":-1})", R"({"do":"run","id":1e16})", R"({"do":"run","id":null})"}) {
        EXPECT_THROW(Request{text}, InputError) << text;
    }
}

TEST(Request, ReadsNumbersWithinTheirRange) {
    EXPECT_EQ(with("3").integer("x", 0, 3), 3);
    EXPECT_EQ(with("3.0").integer("x", 0, 3), 3);
    EXPECT_EQ(with("-2").number("x", -2.0, 0.0), -2.0);
    for (const std::string value :
         {"4", "-1", "2.5", "1e300", "18446744073709551615", "\"2\"", "null", "true", "[2]"})
        expect_refused(value, [](const Request& request) { (void)request.integer("x", 0, 3); });
    for (const std::string value : {"-0.1", "3.1", "1e308", "\"2\"", "null", "{}"})
        expect_refused(value, [](const Request& request) { (void)request.number("x", 0.0, 3.0); });
    EXPECT_THROW(with("1e400"), InputError);  // no number of JSON's
    // An infinite bound does not let infinity in.
    EXPECT_EQ(with("1e308").number("x", 0.0, std::numeric_limits<double>::infinity()), 1e308);
}

TEST(Request, NamesWhatIsMissing) {
    const Request request(R"({"do":"test"})");
    EXPECT_FALSE(request.has("x"));
    for (const auto& reading : std::vector<std::function<void()>>{
             [&] { (void)request.integer("x", 0, 1); }, [&] { (void)request.number("x", 0, 1); },
             [&] { (void)request.flag("x"); }, [&] { (void)request.text("x"); },
             [&] { (void)request.word("x", words); }, [&] { (void)request.vertices("x", 9); },
             [&] { (void)request.numbers("x", 3); }, [&] { (void)request.is_null("x"); },
             [&] { (void)request.pairs("x", 3); }}) {
        try {
            reading();
            ADD_FAILURE() << "it was found";
        } catch (const InputError& error) {
            EXPECT_STREQ(error.what(), "'x' is missing");
        }
    }
}

TEST(Request, ReadsFlagsTextsAndWords) {
    EXPECT_TRUE(with("true").flag("x"));
    EXPECT_EQ(with(R"("gr\u00fcn")").text("x"), "grün");
    EXPECT_EQ(with("\"obj\"").word("x", words), 1U);
    for (const std::string value : {"0", "\"true\"", "null"})
        expect_refused(value, [](const Request& request) { (void)request.flag("x"); });
    for (const std::string value : {"0", "[]", "null"})
        expect_refused(value, [](const Request& request) { (void)request.text("x"); });
    for (const std::string value : {"0", "\"exe\"", "\"\"", "\"PLY\""})
        expect_refused(value, [](const Request& request) { (void)request.word("x", words); });
}

TEST(Request, ReadsLists) {
    EXPECT_EQ(with("[0,8,0]").vertices("x", 9), (std::vector<Index>{0, 8, 0}));
    EXPECT_TRUE(with("[]").vertices("x", 9).empty());
    EXPECT_EQ(with("[1,2.5,-1e12]").numbers("x", 3), (std::vector<double>{1.0, 2.5, -1e12}));
    EXPECT_TRUE(with("null").is_null("x"));
    EXPECT_FALSE(with("null").pairs("x", 2));
    EXPECT_EQ(with("[[1,2],[3,4]]").pairs("x", 2)->back(), std::pair(3.0, 4.0));
    for (const std::string value : {"[9]", "[-1]", "[0.5]", "[null]", "[[0]]", "3", "{\"0\":1}", "null"})
        expect_refused(value, [](const Request& request) { (void)request.vertices("x", 9); });
    for (const std::string value :
         {"[1,2]", "[1,2,3,4]", "[1,2,\"3\"]", "[1,2,1e13]", "{\"a\":1,\"b\":2,\"c\":3}"})
        expect_refused(value, [](const Request& request) { (void)request.numbers("x", 3); });
    for (const std::string value :
         {"[[1,2],[3,4],[5,6]]", "[1,2]", "[[1]]", "[[1,2,3]]", "[[1,null]]", "[[1,1e300]]", "{}"})
        expect_refused(value, [](const Request& request) { (void)request.pairs("x", 2); });
}

}  // namespace
}  // namespace beltrami::view
