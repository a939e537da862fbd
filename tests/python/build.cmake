# cmake -DSOURCES=… -DBUILD=… -DWORK=… -DTYPE=… -DFLAGS=… -DGENERATOR=… [-DLAUNCHER=…] -DCOMPILER=… -DPYTHON=… -P build.cmake
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE code)
  if(NOT code EQUAL 0)
    list(JOIN ARGN " " line)
    message(FATAL_ERROR "${line}: ${code}")
  endif()
endfunction()

# What single machines lack where tests may be skipped; CMake has asked for it where none may (cmake/requirements.cmake).
execute_process(COMMAND ${PYTHON} -c "import ensurepip, os, sysconfig; assert os.path.exists(sysconfig.get_path('include') + '/Python.h')"
  RESULT_VARIABLE code OUTPUT_QUIET ERROR_QUIET)
if(NOT code EQUAL 0)
  message(NOTICE "skipped: needs a Python that makes virtual environments and has its headers (Debian: python3-venv, python3-dev)")
  return()
endif()

# Made once for each list of packages.
file(MAKE_DIRECTORY ${WORK})
file(SHA256 ${SOURCES}/tests/python/requirements.txt wanted)
set(stamp ${WORK}/venv/installed-${wanted})
if(NOT EXISTS ${stamp})
  file(REMOVE_RECURSE ${WORK}/venv ${WORK}/module)
  run(${PYTHON} -m venv ${WORK}/venv)
  run(${WORK}/venv/bin/python -m pip install --quiet --disable-pip-version-check --no-input --only-binary :all: --no-deps
      -r ${SOURCES}/tests/python/requirements.txt)
  run(${WORK}/venv/bin/python -m pip check --disable-pip-version-check)
  file(TOUCH ${stamp})
endif()

file(REMOVE_RECURSE ${WORK}/prefix)
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/prefix --component library)
run(${CMAKE_COMMAND} -S ${SOURCES}/python -B ${WORK}/module -G ${GENERATOR} -DCMAKE_BUILD_TYPE=${TYPE} -DCMAKE_CXX_FLAGS_RELEASE=${FLAGS}
    -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER} -DCMAKE_PREFIX_PATH=${WORK}/prefix
    -DPython_EXECUTABLE=${WORK}/venv/bin/python)
run(${CMAKE_COMMAND} --build ${WORK}/module)
