# find_package(taut): the targets taut::taut (shared) and taut::static of an installed taut.
get_filename_component(taut_lib "${CMAKE_CURRENT_LIST_DIR}/../.." ABSOLUTE)
find_path(taut_INCLUDE_DIR taut.h HINTS "${taut_lib}/../include" "${taut_lib}/../../include" REQUIRED)
if(NOT TARGET taut::taut)
  add_library(taut::taut SHARED IMPORTED)
  set_target_properties(taut::taut PROPERTIES IMPORTED_LOCATION "${taut_lib}/libtaut.so" IMPORTED_SONAME libtaut.so
    INTERFACE_INCLUDE_DIRECTORIES "${taut_INCLUDE_DIR}")
  add_library(taut::static STATIC IMPORTED)
  set_target_properties(taut::static PROPERTIES IMPORTED_LOCATION "${taut_lib}/libtaut.a"
    INTERFACE_INCLUDE_DIRECTORIES "${taut_INCLUDE_DIR}" INTERFACE_LINK_LIBRARIES "m;pthread;dl")
endif()
