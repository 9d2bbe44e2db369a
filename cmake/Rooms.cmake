# beltrami_room(NAME): the library beltrami_NAME of every .cpp below the room's folder.
#
# Includes read <beltrami/ROOM/header.hpp> here as in an installed tree. Each room has an include folder of its own
# that holds only itself, so a room finds the headers of the rooms it links and of no other: the one-way arrows of
# docs/architecture.md are enforced by the compiler.
function(beltrami_room room)
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS *.cpp)
  list(FILTER sources EXCLUDE REGEX "/program/|/view/|/command\\.cpp$")
  set(includes "${PROJECT_BINARY_DIR}/include/${room}")
  file(MAKE_DIRECTORY "${includes}/beltrami")
  if(NOT EXISTS "${includes}/beltrami/${room}")
    file(CREATE_LINK "${CMAKE_CURRENT_SOURCE_DIR}" "${includes}/beltrami/${room}" SYMBOLIC)
  endif()
  add_library(beltrami_${room} STATIC ${sources})
  add_library(Beltrami::${room} ALIAS beltrami_${room})
  set_target_properties(beltrami_${room} PROPERTIES EXPORT_NAME ${room}
    # Sources have helpers of the same name.
    UNITY_BUILD OFF)
  target_compile_features(beltrami_${room} PUBLIC cxx_std_20)
  target_include_directories(beltrami_${room} PUBLIC
    $<BUILD_INTERFACE:${includes}> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_link_libraries(beltrami_${room} PRIVATE $<BUILD_INTERFACE:beltrami_options>)
  # A third of the compile time of a source.
  target_precompile_headers(beltrami_${room} PRIVATE <Eigen/SparseCore> <fmt/format.h> <algorithm> <cmath> <memory>
    <string> <vector>)
endfunction()
