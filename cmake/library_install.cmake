# `cmake --install BUILD --component library`: headers, static libraries, and what find_package(Etendue) reads.
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
install(FILES ${PROJECT_BINARY_DIR}/EtendueConfig.cmake ${PROJECT_BINARY_DIR}/EtendueConfigVersion.cmake
        DESTINATION ${package} COMPONENT library)
