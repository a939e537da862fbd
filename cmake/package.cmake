# `cpack` in the build folder makes two Debian packages for the release it runs on: etendue (the program, its manual, completions,
# scenes) and libetendue-dev (headers, static libraries, what find_package and pkg-config read). It needs dpkg-dev and file, and a
# build that is complete.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME etendue)
set(CPACK_PACKAGE_VENDOR "The Etendue authors")
set(CPACK_PACKAGE_CONTACT "Etendue built by cpack <root@localhost>" CACHE STRING "Maintainer of the packages: NAME <ADDRESS>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # the descriptions below begin with their own
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL Unspecified library)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
# Folders of packages are readable by all, whatever the umask of who builds them.
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)

set(CPACK_DEBIAN_UNSPECIFIED_PACKAGE_NAME etendue)
set(CPACK_DEBIAN_UNSPECIFIED_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_UNSPECIFIED_PACKAGE_SHLIBDEPS ON)
# The Vulkan loader is opened at run time, so dpkg-shlibdeps does not see it; the driver may be that of a GPU.
set(CPACK_DEBIAN_UNSPECIFIED_PACKAGE_DEPENDS libvulkan1)
set(CPACK_DEBIAN_UNSPECIFIED_PACKAGE_RECOMMENDS "mesa-vulkan-drivers | vulkan-icd")
set(CPACK_DEBIAN_UNSPECIFIED_DESCRIPTION
"path tracer in Vulkan compute shaders that proves its pictures
Etendue renders scenes of the Nori teaching renderer and of Mitsuba (0.6, 2
and 3), glTF assets, OBJ and PLY files. It gives the same light on every
device, on the CPU through Mesa's lavapipe if there is no GPU, and every
picture carries its standard error. A second renderer in double precision that
shares no code with the first, and statistical tests with stated false-alarm
rates, show that it is right.")

set(CPACK_DEBIAN_LIBRARY_PACKAGE_NAME libetendue-dev)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SHLIBDEPS OFF)
# Static libraries bring no dependencies of their own; these are those of etendue.pc and EtendueConfig.cmake.
set(CPACK_DEBIAN_LIBRARY_PACKAGE_DEPENDS "libdraco-dev, libfmt-dev, libglm-dev, libjpeg-dev, libmeshoptimizer-dev, libopenexr-dev, libpng-dev, libvulkan1, libwebp-dev, libxxhash-dev, spirv-tools, zlib1g-dev")
set(CPACK_DEBIAN_LIBRARY_PACKAGE_RECOMMENDS "mesa-vulkan-drivers | vulkan-icd")
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SUGGESTS "cmake, pkgconf")
set(CPACK_DEBIAN_LIBRARY_DESCRIPTION
"path tracer in Vulkan compute shaders (library)
Headers and static libraries of Etendue, for programs in C++20 that read or
build scenes, render them and compare the pictures. Both find_package(Etendue)
of CMake and pkg-config find them.")

# What Debian wants of every package, in packages only: /usr/share/doc/NAME with the copyright and both changelogs, and manual pages
# compressed. The time is that of CMake's run, or SOURCE_DATE_EPOCH.
string(TIMESTAMP package_date "%a, %d %b %Y %H:%M:%S +0000" UTC)
foreach(package etendue libetendue-dev)
  set(component Unspecified)
  if(package STREQUAL "libetendue-dev")
    set(component library)
  endif()
  file(WRITE ${PROJECT_BINARY_DIR}/changelog-${package} "etendue (${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE}) unstable; urgency=medium\n\n  * Made by cpack; changelog.gz tells what is new.\n\n -- ${CPACK_PACKAGE_CONTACT}  ${package_date}\n")
  install(CODE "
    set(root \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}\")
    if(root MATCHES \"/_CPack_Packages/.*/usr$\")
      set(doc share/doc/${package})
      file(INSTALL DESTINATION \"\${CMAKE_INSTALL_PREFIX}/\${doc}\" TYPE FILE FILES \"${PROJECT_SOURCE_DIR}/cmake/copyright\")
      file(COPY_FILE \"${PROJECT_BINARY_DIR}/changelog-${package}\" \"\${root}/\${doc}/changelog.Debian\")
      file(COPY_FILE \"${PROJECT_SOURCE_DIR}/CHANGELOG.md\" \"\${root}/\${doc}/changelog\")
      file(GLOB pages \"\${root}/share/man/man1/*.1\")
      set(texts \"\${root}/\${doc}/changelog.Debian\" \"\${root}/\${doc}/changelog\" \${pages})
      file(CHMOD \${texts} PERMISSIONS OWNER_READ OWNER_WRITE GROUP_READ WORLD_READ)
      execute_process(COMMAND gzip -9nf \${texts} COMMAND_ERROR_IS_FATAL ANY)
    endif()" COMPONENT ${component})
endforeach()
include(CPack)
