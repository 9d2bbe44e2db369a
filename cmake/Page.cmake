# beltrami_page(TARGET FOLDER): the page of FOLDER, bundled by Node to one HTML file, as bytes in the target.
#
# Without Node, or without the packages that ./dev setup installs for it, the target is built without: there is no viewer and
# there are no reports then, and everything else is as it is.
function(beltrami_page target folder)
  find_program(NODE node)
  # Globbed, so that a build after ./dev setup notices.
  file(GLOB installed CONFIGURE_DEPENDS "${folder}/node_modules/.package-lock.json")
  if(NOT NODE OR NOT installed)
    message(STATUS "The viewer and reports are left out: there is no Node, or its packages are not installed. Run ./dev setup")
    return()
  endif()
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS "${folder}/src/*")
  set(page "${CMAKE_CURRENT_BINARY_DIR}/page.html")
  add_custom_command(OUTPUT "${page}" COMMAND "${NODE}" build.mjs "${page}" WORKING_DIRECTORY "${folder}"
    DEPENDS ${sources} "${folder}/index.html" "${folder}/build.mjs" "${folder}/package-lock.json" "${installed}"
    COMMENT "Bundling the page" VERBATIM)
  # A C array of a megabyte takes compilers seconds; the assembler takes the file as it is.
  set(bytes "${CMAKE_CURRENT_BINARY_DIR}/page_bytes.S")
  file(CONFIGURE OUTPUT "${bytes}" @ONLY CONTENT [[
    .section .rodata
    .global beltrami_page_begin
    .hidden beltrami_page_begin
beltrami_page_begin:
    .incbin "@page@"
    .global beltrami_page_end
    .hidden beltrami_page_end
beltrami_page_end:
    .byte 0
    .section .note.GNU-stack, "", %progbits
]])
  set_property(SOURCE "${bytes}" PROPERTY OBJECT_DEPENDS "${page}")
  target_sources(${target} PRIVATE "${bytes}")
  set_property(SOURCE view/page.cpp APPEND PROPERTY COMPILE_DEFINITIONS BELTRAMI_PAGE)
endfunction()
