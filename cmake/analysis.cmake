# Static analysis of the sources as they are built. Both targets fail on any finding:
#   cmake --build --preset cppcheck      cmake --preset tidy && cmake --build --preset tidy
find_program(CPPCHECK cppcheck)
if(CPPCHECK)
  # Mistakes, not tastes: what may crash or compute something wrong (warning) and what another compiler takes otherwise (portability).
  # Speed is clang-tidy's part: cppcheck wants every vector of three doubles passed by reference. Macros of the tests' framework
  # would be unknown without its library file.
  add_custom_target(cppcheck
    COMMAND ${CPPCHECK} --enable=warning,portability --std=c++20 --library=googletest --inline-suppr --quiet
            --error-exitcode=1 -I src -I shaders -I tests/gpu/kernels src tests
    WORKING_DIRECTORY ${PROJECT_SOURCE_DIR} USES_TERMINAL VERBATIM)
endif()
