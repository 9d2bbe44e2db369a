#include "../program/run.hpp"

namespace beltrami::program {

void add_info(CLI::App& program, Run& run) {
    auto* const command = program.add_subcommand("info", "what is in a mesh, and what can trouble a solver");
    run.add_options(*command, {.output = false, .solver = false});
    auto json = std::make_shared<bool>(false);
    command->add_flag("--json", *json, "print JSON");
    command->callback([&run, json] {
        if (*json) run.be_quiet();
        run.load_mesh();
        const MeshReport& found = run.mesh_report();
        if (*json) {
            fmt::print("{}\n",
                       view::to_json(found).dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
        } else {
            fmt::print("{}", full_report(found));
        }
        run.finish();
    });
}

}  // namespace beltrami::program
