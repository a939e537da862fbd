# Flags every target of the project gets. Contraction is off: a*b+c on the host is what the source says, so that host-side
# integers derived from floats (BVH bytes, thresholds) are the same on every machine. OpenEXR asks for -pthread, and precompiled headers
# serve those only who were compiled alike.
add_library(etendue_flags INTERFACE)
target_compile_options(etendue_flags INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion
                       -Wno-missing-field-initializers -ffp-contract=off -pthread)
# Of every target, programs too: precompiled headers serve those only who were compiled alike.
# Some releases' image libraries ask for this macro of whoever uses them; then all must have it.
target_compile_definitions(etendue_flags INTERFACE _FILE_OFFSET_BITS=64)
if(ETENDUE_PIC)
  target_compile_options(etendue_flags INTERFACE -fPIC -fvisibility=hidden)  # what others could replace would never be inlined
endif()
foreach(sanitizer IN LISTS ETENDUE_SANITIZE)
  target_compile_options(etendue_flags INTERFACE -fsanitize=${sanitizer} -fno-omit-frame-pointer)
  target_link_options(etendue_flags INTERFACE -fsanitize=${sanitizer})
endforeach()
if(ETENDUE_SANITIZE)
  target_sources(etendue_flags INTERFACE
    $<$<STREQUAL:$<TARGET_PROPERTY:TYPE>,EXECUTABLE>:${PROJECT_SOURCE_DIR}/tests/sanitizers/keep_libraries.c>)
  target_link_options(etendue_flags INTERFACE -Wl,--export-dynamic-symbol=dlclose)
endif()
if("undefined" IN_LIST ETENDUE_SANITIZE)
  target_compile_options(etendue_flags INTERFACE -fno-sanitize-recover=undefined)
endif()
