# Installs the build and builds and runs the consumer against it.
set(stage ${WORK}/stage)
set(build ${WORK}/build)
file(REMOVE_RECURSE ${WORK})
foreach(step
    "${CMAKE_COMMAND};--install;${BINARY_DIR};--prefix;${stage}"
    "${CMAKE_COMMAND};-S;${SOURCE};-B;${build};-G;Ninja;-DCMAKE_PREFIX_PATH=${stage};-DCMAKE_BUILD_TYPE=Release;-DCMAKE_CXX_COMPILER=${COMPILER};-DCMAKE_CXX_FLAGS=${FLAGS}"
    "${CMAKE_COMMAND};--build;${build}"
    "${build}/consumer"
    "${stage}/bin/lamella;--version")
  execute_process(COMMAND ${step} RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "${step} failed:\n${output}")
  endif()
endforeach()
