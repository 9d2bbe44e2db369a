// The command spectrum.

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "beltrami/beltrami.hpp"
#include "expect_text.hpp"
#include "meshes.hpp"
#include "process.hpp"

namespace beltrami::testing {
namespace {

namespace fs = std::filesystem;

/// The header line, and rows of numbers.
struct Table {
    std::string header;
    std::vector<std::vector<double>> rows;
    explicit Table(const fs::path& path) {
        std::ifstream file(path);
        std::getline(file, header);
        for (std::string line; std::getline(file, line);) {
            std::istringstream numbers(line);
            rows.emplace_back();
            for (std::string number; std::getline(numbers, number, ',');)
                rows.back().push_back(std::stod(number));
        }
    }
};

void make_basis(const fs::path& folder, int count) {
    const Outcome outcome = run_beltrami({"harmonics", sphere, "-k", std::to_string(count), "-o", folder});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
}

TEST(ProgramSpectrum, WritesATableAndAChart) {
    const Scratch scratch;
    make_basis(scratch / "b", 49);
    const Outcome outcome =
        run_beltrami({"spectrum", sphere, "--basis", scratch / "b", "--on", "positions", "-o",
                      scratch / "s.csv", "--picture", scratch / "s.png", "--summary", scratch / "s.json"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const Table table(scratch / "s.csv");
    EXPECT_EQ(table.header,
              "number,eigenvalue,frequency,wavelength,eigenvalue_area,eigenvalue_ratio,weyl,amplitude,error");
    ASSERT_EQ(table.rows.size(), 49u);
    EXPECT_TRUE(std::isinf(table.rows[0][3]));
    const double area = read_json(scratch / "s.json")["mesh"]["measure"];
    for (std::size_t k = 0; k < 49; ++k) {
        const std::vector<double>& row = table.rows[k];
        ASSERT_EQ(row.size(), 9u);
        EXPECT_EQ(row[0], static_cast<double>(k));
        EXPECT_NEAR(row[2] * row[2], row[1], 1e-9 * row[1]);
        EXPECT_NEAR(row[4], row[1] * area, 1e-9 * row[4]);
        if (k > 0) {
            EXPECT_NEAR(row[3] * row[2], 2.0 * std::numbers::pi, 1e-9);
            EXPECT_LE(row[8], table.rows[k - 1][8]);
        }
    }
    // The positions of a sphere are its functions 1 to 3.
    EXPECT_EQ(table.rows[1][5], 1.0);
    EXPECT_GT(table.rows[2][8], 0.5);
    EXPECT_LT(table.rows[3][8], 0.01);
    const auto result = read_json(scratch / "s.json")["result"];
    EXPECT_EQ(result["count"], 49);
    EXPECT_EQ(result["error"], table.rows[48][8]);
    EXPECT_EQ(result["zero_modes"], 1);
    EXPECT_GT(fs::file_size(scratch / "s.png"), 5000u);
}

TEST(ProgramSpectrum, WithoutAFieldHasNoErrors) {
    const Scratch scratch;
    make_basis(scratch / "b", 10);
    ASSERT_EQ(run_beltrami({"spectrum", sphere, "--basis", scratch / "b", "-o", scratch / "s.csv"}).status,
              0);
    EXPECT_EQ(Table(scratch / "s.csv").rows.at(4).size(), 7u);
}

TEST(ProgramSpectrum, RefusesWhatCannotBe) {
    const Scratch scratch;
    make_basis(scratch / "b", 5);
    const std::string b = scratch / "b";
    expect_refused(scratch, {"spectrum", sphere, "--basis", scratch / "nothing"}, {"not a folder"});
    expect_refused(scratch, {"spectrum", "shape:icosphere:2", "--basis", b}, {"another mesh"});
    expect_refused(scratch, {"spectrum", sphere, "--basis", b, "--on", "missing"}, {"missing"});
    expect_refused(scratch, {"spectrum", sphere, "--basis", b, "--on", "colors"});
    expect_refused(scratch, {"spectrum", sphere, "--basis", b, "--picture", scratch / "p.gif"}, {".png"});
    expect_refused(scratch, {"spectrum", sphere, "--basis", b, "--picture", (scratch / "no") / "p.png"});
    expect_refused(scratch, {"spectrum", sphere}, {"--basis"});
    const Outcome nowhere = run_beltrami({"spectrum", sphere, "--basis", b});
    EXPECT_EQ(nowhere.status, 2);
    EXPECT_TRUE(contains(nowhere.err, {"nothing would be written", "hint: "}));
}

}  // namespace
}  // namespace beltrami::testing
