// The program `beltrami`: command lines in, files out. What the commands do is in the library; see */command.cpp.

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <cstdio>
#include <new>
#include <string>

#include "run.hpp"

namespace {

int complain(const std::string& what, const std::string& hint, int status) {
    fmt::print(stderr, "error: {}\n", what);
    if (!hint.empty()) fmt::print(stderr, "hint: {}\n", hint);
    return status;
}

int run_program(int argc, char** argv) {
    using namespace beltrami;
    using namespace beltrami::program;

    spdlog::set_default_logger(spdlog::stderr_color_mt("beltrami"));
    spdlog::set_pattern("%l: %v");

    CLI::App program("Heat, waves, interpolation and spectra on meshes, by sparse PDE solvers.", "beltrami");
    program.set_version_flag("--version", "beltrami " BELTRAMI_VERSION);
    program.require_subcommand(1);
    program.footer("beltrami COMMAND --help tells a command's options.\nBuilt-in shapes, for MESH:\n" +
                   shapes::list());
    Run run({argv, argv + argc});
    cancel_on_signal(run.cancellable());
    add_info(program, run);
    add_heat(program, run);
    add_wave(program, run);
    add_interpolate(program, run);
    add_vectors(program, run);
    add_poisson(program, run);
    add_curvature(program, run);
    add_fair(program, run);
    add_membrane(program, run);
    add_poke(program, run);
    add_harmonics(program, run);
    add_filter(program, run);
    add_spectrum(program, run);
    add_signature(program, run);
    add_nodal(program, run);
    add_view(program, run);
    try {
        program.parse(argc, argv);
        if (std::fflush(stdout) != 0) {
            return complain("standard output cannot be written", "the disk may be full, or the pipe closed",
                            2);
        }
        return 0;
    } catch (const CLI::ParseError& error) {
        if (error.get_exit_code() == 0) return program.exit(error);  // --help, --version
        const auto chosen = program.get_subcommands();
        return complain(
            error.what(),
            chosen.empty()
                ? std::string("write beltrami COMMAND MESH [options]; see beltrami --help")
                : fmt::format("write beltrami {0} MESH [options], MESH first; see beltrami {0} --help",
                              chosen.front()->get_name()),
            2);
    }
}

}  // namespace

int main(int argc, char** argv) {
    try {
        return run_program(argc, argv);
    } catch (const beltrami::Error& error) {
        return complain(error.what(), error.hint(), error.exit_status());
    } catch (const std::bad_alloc&) {
        return complain("this machine's memory does not suffice", "use a smaller mesh, or --solver multigrid",
                        3);
    } catch (const std::exception& error) {
        return complain(error.what(), "this is a defect of beltrami; please report it with the command line",
                        1);
    }
}
