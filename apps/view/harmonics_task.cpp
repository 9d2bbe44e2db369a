// Manifold harmonics: eigenfunctions with their certificate, and a filter curve over the spectrum that the surface, its
// normals or its colours follow.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <utility>

#include "beltrami/framework/stopwatch.hpp"
#include "parcel.hpp"
#include "task.hpp"

namespace beltrami::view {

namespace {

const std::vector<std::string> target_words = {"positions", "normals", "colors"};
constexpr std::array targets{FilterTarget::positions, FilterTarget::normals, FilterTarget::colors};
constexpr Index most_functions = 20000;
constexpr std::size_t most_points = 200;

class HarmonicsTask : public Task {
  public:
    using Task::Task;

    [[nodiscard]] std::string name() const override { return "harmonics"; }

    bool handle(const Request& request) override {
        if (request.name() == "harmonics.compute") {
            compute(request);
        } else if (request.name() == "harmonics.show") {
            show(request);
        } else if (request.name() == "harmonics.filter") {
            filter(request);
        } else {
            return false;
        }
        return true;
    }

    void clear(const Request& request) override {
        shown_.reset();
        curve_.reset();
        update(request.id());
    }

    [[nodiscard]] nlohmann::json state() const override {
        nlohmann::json json = {{"computed", basis_ ? basis_->count() : 0},
                               {"shown", nullptr},
                               {"on", target_words[on_]},
                               {"curve", nullptr}};
        if (shown_) json["shown"] = *shown_;
        if (curve_) {
            json["curve"] = nlohmann::json::array();
            for (const FilterCurve::Point& point : curve_->points())
                json["curve"].push_back({point.frequency, point.gain});
        }
        return json;
    }

    [[nodiscard]] std::vector<std::string> command() const override {
        if (!basis_) return {};
        const std::string mesh = shell_word(stage_.argument);
        std::vector<std::string> lines = {
            fmt::format("beltrami harmonics {} -k {} -o BASIS", mesh, basis_->count())};
        if (shown_) lines.front() += fmt::format(" --show {} --picture function.png", *shown_);
        if (!curve_) return lines;
        std::string line = fmt::format("beltrami filter {} --basis BASIS --filter curve:", mesh);
        for (const FilterCurve::Point& point : curve_->points())
            line += fmt::format("{}{}={}", line.back() == ':' ? "" : ",", point.frequency, point.gain);
        lines.push_back(line + fmt::format(" --on {} -o harmonics.ply", target_words[on_]));
        return lines;
    }

    [[nodiscard]] std::vector<Outgoing> newest() const override {
        std::vector<Outgoing> messages;
        if (spectrum_) messages.push_back(*spectrum_);
        // The one that is not shown comes first: the page takes the last.
        for (const std::optional<Outgoing>& message :
             {curve_ ? function_ : filtering_, curve_ ? filtering_ : function_}) {
            if (message) messages.push_back(*message);
        }
        return messages;
    }

    [[nodiscard]] Saved saved() const override {
        if (!basis_) throw InputError("no harmonics are computed yet", "press Compute first");
        std::string csv = "number,eigenvalue,frequency\n";
        for (Index k = 0; k < basis_->count(); ++k) {
            const double lambda = basis_->eigenvalues()[k];
            csv += fmt::format("{},{},{}\n", k, lambda, std::sqrt(std::max(lambda, 0.0)));
        }
        if (filtered_.size() > 0 && curve_)
            return {filtered(stage_.mesh, targets[filtered_on_], filtered_), {}, csv};
        if (shown_)
            return {
                stage_.mesh, {{fmt::format("function-{}", *shown_), Block(basis_->function(*shown_))}}, csv};
        return {stage_.mesh, {}, csv};
    }

  private:
    void compute(const Request& request) {
        const Index most =
            std::min<Index>(most_functions, stage_.vertex_count() - stage_.laplacian().isolated_vertices());
        const Index count = request.integer("count", 1, most);
        stage_.post(name(), request.id(), true,
                    [this, count](const Progress& progress) { return find(count, progress); });
    }

    std::string find(Index count, const Progress& progress) {
        const Eigenproblem problem(stage_.laplacian());
        const std::filesystem::path folder = stage_.scratch / "basis";
        const BasisOperator description{"dec", "lumped", fingerprint(Constraints())};
        SpectrumSummary summary;
        {
            // What an earlier, shorter or cancelled, run found is gone on with.
            BasisWriter writer(folder, stage_.mesh, stage_.laplacian(), problem, description,
                               {.resume = true});
            SpectrumOptions options{.count = count, .progress = &progress};
            if (!writer.satisfies(options)) {
                options = writer.continued(options);
                summary = spectrum(problem, options, writer.sink());
                writer.finish(summary);
            }
        }
        auto basis = std::make_shared<const StoredBasis>(folder);
        std::vector<std::string> certificate = {
            fmt::format("{} functions, {}", basis->count(),
                        basis->complete() ? "complete: inertia says that none is missing" : "NOT complete"),
            fmt::format("residuals below {:.2g}, orthonormal to {:.2g}", basis->max_residual(),
                        basis->max_orthogonality_error())};
        for (const BandCertificate& band : basis->certificates()) {
            certificate.push_back(fmt::format("{} eigenvalues between {:.6g} and {:.6g}, {} found",
                                              band.upper.below - band.lower.below, band.lower.value,
                                              band.upper.value, band.found));
        }
        nlohmann::json header = {{"kind", "spectrum"},
                                 {"count", basis->count()},
                                 {"complete", basis->complete()},
                                 {"certificate", certificate},
                                 {"cutoff", cutoff_frequency(*basis)},
                                 {"nyquist", nyquist_frequency(basis->mean_edge())}};
        Parcel parcel(std::move(header));
        parcel.add("frequencies", Vector(basis->eigenvalues().cwiseMax(0.0).cwiseSqrt()));
        const std::lock_guard lock(stage_.mutex);
        basis_ = basis;
        if (shown_ && *shown_ >= basis->count()) shown_.reset();
        stage_.running.reset();  // a request that answers this message finds the solver free
        spectrum_ = parcel_message(parcel.bytes());
        stage_.broadcast(*spectrum_);
        return summary.count > 0 ? summary.brief() : "they were there already";
    }

    void require_basis() const {
        if (!basis_) throw InputError("no harmonics are computed yet", "press Compute first");
    }

    void show(const Request& request) {
        require_basis();
        shown_.reset();
        if (!request.is_null("k")) shown_ = request.integer("k", 0, basis_->count() - 1);
        curve_.reset();
        update(request.id());
    }

    void filter(const Request& request) {
        require_basis();
        const std::size_t on = request.word("on", target_words);
        if (targets[on] == FilterTarget::colors && stage_.mesh.find_field("color") == nullptr)
            throw InputError("the mesh has no colours", "filter its positions or its normals");
        const auto pairs = request.pairs("curve", most_points);
        std::optional<FilterCurve> curve;
        if (pairs) {
            std::vector<FilterCurve::Point> points;
            for (const auto& [frequency, gain] : *pairs)
                points.push_back({frequency, gain});
            curve.emplace(std::move(points));
        }
        on_ = on;
        curve_ = std::move(curve);
        shown_.reset();
        update(request.id());
    }

    // With the mutex locked.
    void update(long id) {
        asked_ = id;
        stage_.post(name() + " update", id, false, [this](const Progress& progress) {
            draw(progress);
            return std::string();
        });
    }

    void draw(const Progress& progress) {
        const Stopwatch watch;
        std::shared_ptr<const StoredBasis> basis;
        std::optional<Index> shown;
        std::optional<FilterCurve> curve;
        std::size_t on = 0;
        long id = 0;
        {
            const std::lock_guard lock(stage_.mutex);
            basis = basis_;
            shown = shown_;
            curve = curve_;
            on = on_;
            id = asked_;
        }
        Block result;
        nlohmann::json extra = {{"on", target_words[on]}};
        std::string array = "positions";
        if (shown && basis) {
            result = basis->function(*shown);
            array = "values";
            extra = {{"shown", *shown},
                     {"frequency", std::sqrt(std::max(basis->eigenvalues()[*shown], 0.0))}};
        } else if (curve && basis) {
            const HarmonicFilter& harmonic = filter_of(on, basis, progress);
            result = harmonic.apply(*curve);
            array = target_words[on];
            extra["roughness"] = energy(result) / energy_before_[on];
            if (targets[on] == FilterTarget::normals) {
                result.rowwise().normalize();
            } else if (targets[on] == FilterTarget::colors) {
                result = clamped(result, 0.0, 1.0).value;
            }
        } else {
            result = stage_.mesh.points();
            extra["roughness"] = 1.0;
        }
        nlohmann::json header = frame_header(name(), id, watch.seconds(), "");
        header.update(extra);
        Parcel parcel(std::move(header));
        parcel.add(array, result);
        const std::lock_guard lock(stage_.mutex);
        std::optional<Outgoing>& kept = array == "values" ? function_ : filtering_;
        kept = parcel_message(parcel.bytes(), name() + array);
        if (!shown && !curve) function_.reset();
        filtered_ = curve ? std::move(result) : Block();
        filtered_on_ = on;
        stage_.broadcast(*kept);
    }

    [[nodiscard]] double energy(const Block& field) const {
        return dirichlet_energy(stage_.laplacian(), stage_.laplacian().order().to_working(field));
    }

    const HarmonicFilter& filter_of(std::size_t on, const std::shared_ptr<const StoredBasis>& basis,
                                    const Progress& progress) {
        if (filter_basis_ != basis) {
            for (auto& filter : filters_)
                filter.reset();
            filter_basis_ = basis;
        }
        if (!filters_[on]) {
            const Block field = filter_field(stage_.mesh, targets[on]);
            energy_before_[on] = std::max(energy(field), 1e-300);
            filters_[on] = std::make_unique<HarmonicFilter>(*basis, field, &progress);
        }
        return *filters_[on];
    }

    std::shared_ptr<const StoredBasis> basis_;
    std::optional<Index> shown_;
    std::optional<FilterCurve> curve_;
    std::size_t on_ = 0;
    long asked_ = 0;
    Block filtered_;
    std::size_t filtered_on_ = 0;
    std::optional<Outgoing> spectrum_;
    std::optional<Outgoing> function_;   // the newest eigenfunction
    std::optional<Outgoing> filtering_;  // the newest filtered field
    // Of the solver thread alone.
    std::shared_ptr<const StoredBasis> filter_basis_;
    std::array<std::unique_ptr<HarmonicFilter>, 3> filters_;
    std::array<double, 3> energy_before_{};
};

}  // namespace

std::unique_ptr<Task> make_harmonics_task(Stage& stage) {
    return std::make_unique<HarmonicsTask>(stage);
}

}  // namespace beltrami::view
