# `cmake --install BUILD --component library`: headers, static libraries, and what find_package(Etendue) and pkg-config read.
include(CMakePackageConfigHelpers)
set(package ${CMAKE_INSTALL_LIBDIR}/cmake/Etendue)
set(parts core image scene formats render compile vulkan gpu reference validate library)
list(TRANSFORM parts PREPEND etendue_)
install(TARGETS ${parts} EXPORT EtendueTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library)
install(EXPORT EtendueTargets NAMESPACE etendue:: DESTINATION ${package} COMPONENT library)
install(DIRECTORY ${PROJECT_BINARY_DIR}/include/etendue DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT library)
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/EtendueConfig.cmake.in ${PROJECT_BINARY_DIR}/EtendueConfig.cmake
                              INSTALL_DESTINATION ${package})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/EtendueConfigVersion.cmake COMPATIBILITY SameMinorVersion)

# pkg-config: the same for programs that do not use CMake. Paths are relative to the file, so that the tree can be moved.
file(RELATIVE_PATH relative_prefix /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
string(REGEX REPLACE "/$" "" relative_prefix "${relative_prefix}")
# The linker takes what it needs from left to right.
set(archives -letendue -letendue_formats -letendue_validate -letendue_gpu -letendue_reference -letendue_compile -letendue_vulkan -letendue_render
  -letendue_scene -letendue_image -letendue_core)
list(JOIN archives " " archives)
configure_file(${PROJECT_SOURCE_DIR}/cmake/etendue.pc.in ${PROJECT_BINARY_DIR}/etendue.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/etendue.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT library)

install(FILES ${PROJECT_BINARY_DIR}/EtendueConfig.cmake ${PROJECT_BINARY_DIR}/EtendueConfigVersion.cmake
        DESTINATION ${package} COMPONENT library)
