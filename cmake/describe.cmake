# What a program says about itself, written by the program at build time: the manual page and the scripts for shells that complete its
# options. The target `manual` makes them for every program that etendue_describe is called for; ./run needs none of it, nor does a project
# that has this one as a part.
if(PROJECT_IS_TOP_LEVEL)
  add_custom_target(manual ALL)
endif()

# etendue_describe(target)
function(etendue_describe target)
  if(NOT PROJECT_IS_TOP_LEVEL)
    return()
  endif()
  set(folder ${CMAKE_CURRENT_BINARY_DIR}/manual)
  set(files ${folder}/${target}.1 ${folder}/${target}.bash ${folder}/${target}.zsh ${folder}/${target}.fish)
  add_custom_command(
    OUTPUT ${files}
    COMMAND ${CMAKE_COMMAND} -DPROGRAM=$<TARGET_FILE:${target}> -DNAME=${target} -DFOLDER=${folder} -P ${PROJECT_SOURCE_DIR}/cmake/describe_program.cmake
    DEPENDS ${target} ${PROJECT_SOURCE_DIR}/cmake/describe_program.cmake
    COMMENT "Writing the manual page of ${target}"
    VERBATIM)
  add_custom_target(manual-${target} DEPENDS ${files})
  add_dependencies(manual manual-${target})
  install(FILES ${folder}/${target}.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
  install(FILES ${folder}/${target}.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME ${target})
  install(FILES ${folder}/${target}.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d)
  # zsh as Debian builds it looks for what packages bring, below /usr, elsewhere than for what administrators install below /usr/local.
  install(CODE "set(site site-functions)
    if(\"\${CMAKE_INSTALL_PREFIX}\" MATCHES \"/usr$\" AND EXISTS /etc/debian_version)
      set(site vendor-completions)
    endif()
    file(INSTALL DESTINATION \"\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_DATADIR}/zsh/\${site}\" TYPE FILE RENAME _${target} FILES \"${folder}/${target}.zsh\")")
endfunction()
