# cmake --install, and the package that find_package(Beltrami) finds.
include(CMakePackageConfigHelpers)

# Headers that only their own room includes stay at home.
foreach(room framework operators solvers apps)
  install(DIRECTORY "${PROJECT_SOURCE_DIR}/${room}/" DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/beltrami/${room}"
    FILES_MATCHING PATTERN "*.hpp"
    PATTERN "formats" EXCLUDE PATTERN "shapes" EXCLUDE PATTERN "program" EXCLUDE PATTERN "view" EXCLUDE
    PATTERN "beltrami.hpp" EXCLUDE
    PATTERN "rasterizer.hpp" EXCLUDE PATTERN "lettering.hpp" EXCLUDE PATTERN "sheet.hpp" EXCLUDE
    PATTERN "ticks.hpp" EXCLUDE PATTERN "supernodal_kernels*.hpp" EXCLUDE PATTERN "supernodal_factor.hpp" EXCLUDE
    PATTERN "chebyshev.hpp" EXCLUDE PATTERN "flush_to_zero.hpp" EXCLUDE PATTERN "row_range.hpp" EXCLUDE
    PATTERN "sliced_rows*.hpp" EXCLUDE PATTERN "sparse_rows.hpp" EXCLUDE PATTERN "wavefront.hpp" EXCLUDE)
endforeach()
install(FILES "${PROJECT_SOURCE_DIR}/apps/beltrami.hpp" DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/beltrami")
install(TARGETS beltrami_framework beltrami_operators beltrami_solvers beltrami_apps beltrami_all
  EXPORT BeltramiTargets)
install(TARGETS beltrami)

set(destination "${CMAKE_INSTALL_LIBDIR}/cmake/Beltrami")
install(EXPORT BeltramiTargets NAMESPACE Beltrami:: DESTINATION "${destination}")
configure_package_config_file(cmake/BeltramiConfig.cmake.in BeltramiConfig.cmake INSTALL_DESTINATION "${destination}")
write_basic_package_version_file(BeltramiConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES "${PROJECT_BINARY_DIR}/BeltramiConfig.cmake" "${PROJECT_BINARY_DIR}/BeltramiConfigVersion.cmake"
  cmake/FindCHOLMOD.cmake cmake/FindMUMPS.cmake DESTINATION "${destination}")
