#include "beltrami/solvers/stored_basis.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <memory>

#include "beltrami/framework/error.hpp"
#include "beltrami/framework/shapes.hpp"
#include "beltrami/solvers/harmonic_transform.hpp"
#include "meshes.hpp"
#include "numerics.hpp"

namespace beltrami {
namespace {

namespace fs = std::filesystem;
using testing::Scratch;

struct Made {
    explicit Made(Mesh m) : mesh(std::move(m)), laplacian(mesh), problem(laplacian) {}
    SpectrumSummary store(const fs::path& folder, Index count, const BasisWriterOptions& writing = {},
                          Index stop_after = 1000) const {
        BasisWriter writer(folder, mesh, laplacian, problem, {}, writing);
        SpectrumOptions options;
        options.count = count;
        options.method = SpectrumMethod::bands;
        options.band = 32;
        Index bands = 0;
        const SpectrumSummary summary =
            spectrum(problem, writer.continued(options), [&](const SpectralBand& band) {
                if (bands++ == stop_after) throw Cancelled();
                writer.add(band);
            });
        writer.finish(summary);
        return summary;
    }
    Mesh mesh;
    Laplacian laplacian;
    Eigenproblem problem;
};

// |K h - lambda M h| / (lambda |M h|) of every stored pair, in the file's order.
double worst_residual(const Made& made, const StoredBasis& basis) {
    double worst = 0.0;
    for (Index k = 1; k < basis.count(); ++k) {
        const Vector h = basis.function(k);
        const Block working = made.laplacian.order().to_working(Block(h));
        Block Kh;
        made.laplacian.stiffness().apply(working, Kh);
        const Vector Mh = basis.apply_mass(Block(h)).col(0);
        const double lambda = basis.eigenvalues()[k];
        worst = std::max(
            worst, (made.laplacian.order().to_user(Kh).col(0) - lambda * Mh).norm() / (lambda * Mh.norm()));
    }
    return worst;
}

TEST(StoredBasis, HoldsWhatWasFound) {
    const Scratch folder;
    const Made made(shapes::shuffled(shapes::bumpy_sphere(1200)).mesh);
    made.store(folder / "b", 80);
    const StoredBasis basis(folder / "b");
    EXPECT_EQ(basis.count(), 80);
    EXPECT_TRUE(basis.complete());
    EXPECT_EQ(basis.zero_modes(), 1);
    EXPECT_GE(basis.bands().size(), 2u);
    EXPECT_LT(worst_residual(made, basis), 1e-8);
    EXPECT_NEAR(basis.mass().sum(), made.laplacian.mass().sum(), 1e-12);
    const Columns H = inverse_transform(basis, Block::Identity(80, 80));
    const Columns gram = H.transpose() * basis.mass().asDiagonal() * H;
    EXPECT_LT((gram - Columns::Identity(80, 80)).cwiseAbs().maxCoeff(), 1e-8);
    EXPECT_NO_THROW(basis.check(made.mesh));
    EXPECT_THROW((void)basis.function(80), InputError);
}

TEST(StoredBasis, ConsistentMassAndHeldVertices) {
    const Scratch folder;
    const Mesh mesh = shapes::grid(20, 16);
    const Laplacian laplacian(mesh);
    Constraints held;
    for (Index v = 0; v < 21; ++v)
        held.fix(v, 0.0);
    const EdgeOperator<double> mass =
        consistent_mass(laplacian.order().to_working(mesh), laplacian.stiffness().shared_graph());
    const Eigenproblem problem(laplacian, mass, laplacian.order().to_working(held));
    BasisWriter writer(folder / "b", mesh, laplacian, problem,
                       {.mass = "consistent", .held = fingerprint(held)}, {});
    writer.finish(spectrum(problem, {.count = 30}, writer.sink()));
    const StoredBasis basis(folder / "b");
    EXPECT_EQ(basis.function(3).head(21).cwiseAbs().maxCoeff(), 0.0);
    const Columns H = inverse_transform(basis, Block::Identity(30, 30));
    const Columns gram = H.transpose() * basis.apply_mass(Block(H));
    EXPECT_LT((gram - Columns::Identity(30, 30)).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(StoredBasis, AStoppedRunGoesOn) {
    const Scratch folder;
    const Made made(shapes::bumpy_sphere(1500));
    made.store(folder / "whole", 120);
    EXPECT_THROW(made.store(folder / "b", 120, {}, 2), Cancelled);
    {
        const StoredBasis stopped(folder / "b");
        EXPECT_FALSE(stopped.complete());
        EXPECT_EQ(stopped.bands().size(), 2u);
    }
    // What a killed run leaves: a file that was being written, a band that the manifest does not list yet.
    std::ofstream(folder / "b/.band-00002.npy.1-1.part") << "half";
    fs::copy_file(folder / "b/band-00000.npy", folder / "b/band-00002.npy");
    const auto first_band = fs::last_write_time(folder / "b/band-00000.npy");
    const SpectrumSummary rest = made.store(folder / "b", 120, {.resume = true});
    EXPECT_EQ(fs::last_write_time(folder / "b/band-00000.npy"), first_band);
    EXPECT_FALSE(fs::exists(folder / "b/.band-00002.npy.1-1.part"));
    const StoredBasis resumed(folder / "b");
    const StoredBasis whole(folder / "whole");
    EXPECT_TRUE(resumed.complete());
    EXPECT_LT(rest.count, 120);
    ASSERT_EQ(resumed.count(), 120);
    EXPECT_LT(testing::relative_difference(resumed.eigenvalues(), whole.eigenvalues()), 1e-10);
    EXPECT_LT(worst_residual(made, resumed), 1e-8);
}

TEST(StoredBasis, GrowsFromASmallerCount) {
    const Scratch folder;
    const Made made(shapes::bumpy_sphere(1500));
    made.store(folder / "b", 50);
    made.store(folder / "b", 100, {.resume = true});
    const StoredBasis basis(folder / "b");
    EXPECT_EQ(basis.count(), 100);
    EXPECT_LT(worst_residual(made, basis), 1e-8);
}

TEST(StoredBasis, FloatsTakeHalfTheRoom) {
    const Scratch folder;
    const Made made(shapes::bumpy_sphere(1200));
    made.store(folder / "b", 60, {.type = NpyType::float32}, 1000);
    const StoredBasis basis(folder / "b");
    EXPECT_LT(fs::file_size(folder / "b/band-00000.npy"), 4u * 1200u * basis.bands()[0].rows() + 200u);
    EXPECT_LT(worst_residual(made, basis), 1e-2);  // K enlarges the rounding of rough parts
    const Columns H = inverse_transform(basis, Block::Identity(60, 60));
    const Columns gram = H.transpose() * basis.mass().asDiagonal() * H;
    EXPECT_LT((gram - Columns::Identity(60, 60)).cwiseAbs().maxCoeff(), 1e-6);
    EXPECT_THROW(made.store(folder / "b", 80, {.resume = true}), InputError);
}

// For Figure 2 C of Vallet & Levy 2008: as if functions were orthogonal without the mass.
TEST(StoredBasis, APlainProductHasNoMass) {
    const Scratch folder;
    const Made made(shapes::bumpy_sphere(600));
    made.store(folder / "b", 20, {.plain_product = true});
    const StoredBasis basis(folder / "b");
    EXPECT_EQ(basis.mass(), Vector::Ones(600));
    for (Index k = 0; k < 20; ++k)
        EXPECT_NEAR(basis.function(k).norm(), 1.0, 1e-12) << k;
}

TEST(StoredBasis, RefusesOtherMeshesAndOperators) {
    const Scratch folder;
    const Made made(shapes::bumpy_sphere(600));
    made.store(folder / "b", 20);
    Points moved = made.mesh.points();
    moved(5, 1) += 1e-12;
    EXPECT_THROW(StoredBasis(folder / "b").check(made.mesh.with_points(moved)), InputError);
    EXPECT_THROW(StoredBasis(folder / "b").check(shapes::bumpy_sphere(700)), InputError);
    EXPECT_THROW(made.store(folder / "b", 20), InputError);  // there already
    const auto open = [&](const Mesh& mesh, const BasisOperator& of) {
        BasisWriter(folder / "b", mesh, made.laplacian, made.problem, of, {.resume = true});
    };
    EXPECT_THROW(open(made.mesh.with_points(moved), {}), InputError);
    EXPECT_THROW(open(made.mesh, {.mass = "voronoi"}), InputError);
    EXPECT_NO_THROW(open(made.mesh, {}));
    fs::create_directories(folder / "other");
    std::ofstream(folder / "other/thesis.txt") << "precious";
    EXPECT_THROW(BasisWriter(folder / "other", made.mesh, made.laplacian, made.problem, {}, {}), InputError);
    EXPECT_TRUE(fs::exists(folder / "other/thesis.txt"));
}

TEST(StoredBasis, NamesTheFileThatIsDamaged) {
    const Scratch folder;
    const Made made(shapes::bumpy_sphere(600));
    made.store(folder / "good", 60);
    EXPECT_THROW(StoredBasis(folder / "none"), InputError);
    const auto damaged = [&](const std::string& file, const std::string& named, const auto& damage) {
        fs::remove_all(folder / "b");
        fs::copy(folder / "good", folder / "b");
        damage(folder / "b" / file);
        try {
            const StoredBasis basis(folder / "b");
            ADD_FAILURE() << file << " was accepted";
        } catch (const InputError& error) {
            EXPECT_NE(std::string(error.what()).find(named), std::string::npos) << error.what();
        }
    };
    const auto remove = [](const fs::path& file) { fs::remove(file); };
    const auto cut = [](const fs::path& file) { fs::resize_file(file, fs::file_size(file) - 8); };
    const auto replace = [](const fs::path& file) { std::ofstream(file) << "{}"; };
    for (const char* file : {"band-00001.npy", "eigenvalues.npy", "mass.npy"}) {
        damaged(file, file, remove);
        damaged(file, file, cut);
        damaged(file, file, replace);
    }
    damaged("manifest.json", "manifest.json", remove);
    damaged("manifest.json", "manifest.json", cut);
    damaged("manifest.json", "manifest.json", replace);
    damaged("band-00000.npy", "band-00000.npy", [&](const fs::path& file) {
        fs::copy_file(folder / "good/band-00001.npy", file, fs::copy_options::overwrite_existing);
    });
}

}  // namespace
}  // namespace beltrami
