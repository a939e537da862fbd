# Writes the tests of every driver that has a device which is not the one that all other tests run on. SwiftShader, where it is installed, always has its
# tests: they fail where it cannot be opened.
cmake_minimum_required(VERSION 3.25)

# The device that 'auto' takes, as "name, driver"; empty where there is none. Further arguments are set in the environment.
function(device_of result)
  execute_process(COMMAND ${CMAKE_COMMAND} -E env ${ARGN} ${ETENDUE} devices --json OUTPUT_VARIABLE json RESULT_VARIABLE code ERROR_QUIET)
  set(${result} "" PARENT_SCOPE)
  if(NOT code EQUAL 0)
    return()
  endif()
  string(JSON count LENGTH "${json}")
  while(count GREATER 0)
    math(EXPR count "${count} - 1")
    string(JSON taken GET "${json}" ${count} auto)
    if(taken)
      string(JSON name GET "${json}" ${count} name)
      string(JSON driver GET "${json}" ${count} driver)
      set(${result} "${name}, ${driver}" PARENT_SCOPE)
    endif()
  endwhile()
endfunction()

set(text "")
# driver_test(NAME command…): for the present driver, named by `driver` and `environment`.
function(driver_test name)
  set(words "")
  foreach(word IN LISTS ARGN)
    string(APPEND words " [==[${word}]==]")
  endforeach()
  string(APPEND text "add_test([==[drivers.${driver}.${name}]==]${words})\n"
                     "set_tests_properties([==[drivers.${driver}.${name}]==] PROPERTIES LABELS drivers TIMEOUT 600 ENVIRONMENT [==[${environment}]==])\n")
  set(text "${text}" PARENT_SCOPE)
endfunction()

device_of(default)
list(REMOVE_DUPLICATES MANIFESTS)
set(known "${default}")
foreach(manifest IN LISTS SWIFTSHADER MANIFESTS)
  # Loaders before 1.3.207 know the second name only.
  set(environment VK_DRIVER_FILES=${manifest} VK_ICD_FILENAMES=${manifest})
  device_of(device ${environment})
  if(manifest STREQUAL SWIFTSHADER)
    set(driver SwiftShader)
  elseif(NOT device OR device IN_LIST known)
    continue()
  else()
    string(REGEX REPLACE ", .*" "" driver "${device}")
    string(MAKE_C_IDENTIFIER "${driver}" driver)
  endif()
  list(APPEND known "${device}")
  message(STATUS "Tests on another driver, ${driver}: ${device}")
  # What takes seconds where a kernel of middle size does; and not the two whose tables are longer than the 65 536 texels that Vulkan guarantees: their
  # kernels, other than the renderer's, have no second build that reads storage buffers.
  driver_test(gpu ${GPU_TESTS} --gtest_filter=DeviceMath.*:DeviceTables.*:DeviceFilm.*:DeviceCamera.*:DeviceLoops.*:DeviceIntersect.*:DeviceEnvironment.*:DeviceTextures.*:RayCasting.*-DeviceEnvironment.AgreesWithTheReferenceAtEverySize:DeviceTextures.LookupsAreThoseOfTheReference)
  foreach(scene cbox-sphere bubble lamps)
    driver_test(validate.${scene} ${ETENDUE} validate --require rounding --size 64x48 --spp 16 --samples 8000 ${SOURCE}/scenes/${scene}.xml)
  endforeach()
  # The course tests, and a kernel with all features.
  driver_test(ttest-direct ${ETENDUE} ttest --strict --allow-untested --samples 4000 ${SOURCE}/scenes/ttest-direct.xml)
  driver_test(ttest-furnace ${ETENDUE} ttest --strict --allow-untested --samples 4000 ${SOURCE}/scenes/ttest-furnace.xml)
  driver_test(all-features ${ETENDUE} ttest --strict --allow-untested --samples 2000 ${SOURCE}/tests/scenes/bsdf_gltf.xml)
endforeach()
file(WRITE ${OUTPUT} "${text}")
