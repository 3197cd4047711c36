# The few rules that every folder's CMakeLists.txt uses.

add_library(pleat_options INTERFACE)
target_compile_options(pleat_options INTERFACE -Wall -Wextra -Wpedantic -ffp-contract=off)
if(PLEAT_WARNINGS_AS_ERRORS)
  target_compile_options(pleat_options INTERFACE -Werror)
endif()
if(PLEAT_SANITIZE)
  add_compile_options(-fsanitize=address,undefined -fno-omit-frame-pointer)
  add_link_options(-fsanitize=address,undefined)
endif()
if(PLEAT_FUZZ)
  add_compile_options(-fsanitize=fuzzer-no-link)
endif()

# pleat_library(core SOURCES a.cpp ... PUBLIC libs... PRIVATE libs...)
# makes the static library pleat_core, known as pleat::core, with includes that start at the root.
function(pleat_library room)
  cmake_parse_arguments(ARG "" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  add_library(pleat_${room} STATIC ${ARG_SOURCES})
  add_library(pleat::${room} ALIAS pleat_${room})
  set_target_properties(pleat_${room} PROPERTIES EXPORT_NAME ${room})
  target_include_directories(pleat_${room} PUBLIC
    $<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/pleat>)
  target_compile_features(pleat_${room} PUBLIC cxx_std_17)
  target_link_libraries(pleat_${room} PUBLIC ${ARG_PUBLIC}
    PRIVATE $<BUILD_INTERFACE:pleat_options> ${ARG_PRIVATE})
  set_property(GLOBAL APPEND PROPERTY PLEAT_ROOMS ${room})
endfunction()

# pleat_tests(core LABEL fast SOURCES a_test.cpp ... LIBRARIES pleat::core ... WHOLE Suite ...)
# ctest runs each test in a process of its own, but a suite that sets up much is one test to it (WHOLE).
function(pleat_tests name)
  cmake_parse_arguments(ARG "" "LABEL" "SOURCES;LIBRARIES;WHOLE" ${ARGN})
  add_executable(${name}_tests ${ARG_SOURCES})
  target_link_libraries(${name}_tests PRIVATE ${ARG_LIBRARIES} pleat_options GTest::gmock GTest::gtest_main)
  target_compile_definitions(${name}_tests PRIVATE PLEAT_SOURCE_DIR="${CMAKE_SOURCE_DIR}")
  foreach(suite ${ARG_WHOLE})
    add_test(NAME ${suite} COMMAND ${name}_tests --gtest_filter=${suite}.*)
    set_tests_properties(${suite} PROPERTIES LABELS ${ARG_LABEL} TIMEOUT 900)
    list(APPEND whole "${suite}.*")
  endforeach()
  list(JOIN whole ":" whole)
  gtest_discover_tests(${name}_tests TEST_FILTER "*-${whole}" DISCOVERY_TIMEOUT 120
    PROPERTIES LABELS ${ARG_LABEL} TIMEOUT 600)
endfunction()

# Installs every room as pleat::<room>, its headers, and the package config for find_package(pleat).
function(pleat_install_package)
  include(CMakePackageConfigHelpers)
  get_property(rooms GLOBAL PROPERTY PLEAT_ROOMS)
  foreach(room ${rooms})
    install(TARGETS pleat_${room} EXPORT pleatTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
    string(REPLACE "_config" "" folder ${room})
    install(DIRECTORY ${CMAKE_SOURCE_DIR}/${folder} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/pleat
            FILES_MATCHING PATTERN "*.h")
  endforeach()
  install(EXPORT pleatTargets NAMESPACE pleat:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/pleat)
  configure_package_config_file(${CMAKE_SOURCE_DIR}/cmake/pleatConfig.cmake.in
    ${CMAKE_BINARY_DIR}/pleatConfig.cmake INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/pleat)
  write_basic_package_version_file(${CMAKE_BINARY_DIR}/pleatConfigVersion.cmake
    COMPATIBILITY SameMinorVersion)
  install(FILES ${CMAKE_BINARY_DIR}/pleatConfig.cmake ${CMAKE_BINARY_DIR}/pleatConfigVersion.cmake
          DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/pleat)
endfunction()
