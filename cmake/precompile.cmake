# What nearly every source file includes, parsed once: a build from nothing takes two thirds of the time. Only by GCC, and only without a
# compiler cache: the cache serves repeated builds better, would have to be told to trust precompiled headers, and its builds see which file
# forgets an include.
set(ETENDUE_PRECOMPILE OFF)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND NOT CMAKE_CXX_COMPILER_LAUNCHER AND NOT CMAKE_CXX_CLANG_TIDY)
  set(ETENDUE_PRECOMPILE ON)
  file(WRITE ${CMAKE_BINARY_DIR}/precompiled.cpp "// Only its precompiled headers are wanted.\n")
  add_library(etendue_precompiled OBJECT EXCLUDE_FROM_ALL ${CMAKE_BINARY_DIR}/precompiled.cpp)
  target_link_libraries(etendue_precompiled PRIVATE fmt::fmt glm::glm Threads::Threads etendue_flags)
  target_precompile_headers(etendue_precompiled PRIVATE
    <algorithm> <array> <chrono> <cmath> <cstdint> <filesystem> <functional> <limits> <map> <memory> <optional> <span> <string> <variant>
    <vector> <fmt/format.h> <fmt/ranges.h> <glm/glm.hpp>)
endif()

# The target's files see those headers.
function(etendue_precompile target)
  if(ETENDUE_PRECOMPILE)
    target_precompile_headers(${target} REUSE_FROM etendue_precompiled)
  endif()
endfunction()
