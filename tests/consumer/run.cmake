# Installs the build, builds and runs the consumer against it, and runs the installed program with
# its module of OpenVDB (-DOPENVDB=ON) in its place, beside the program, and missing.
set(stage ${WORK}/stage)
set(build ${WORK}/build)
file(REMOVE_RECURSE ${WORK})
foreach(step
    "${CMAKE_COMMAND};--install;${BINARY_DIR};--prefix;${stage}"
    "${CMAKE_COMMAND};-S;${SOURCE};-B;${build};-G;Ninja;-DCMAKE_PREFIX_PATH=${stage};-DCMAKE_BUILD_TYPE=Release;-DCMAKE_CXX_COMPILER=${COMPILER};-DCMAKE_CXX_FLAGS=${FLAGS}"
    "${CMAKE_COMMAND};--build;${build}"
    "${build}/consumer;${WORK}/consumer.vdb"
    "${stage}/bin/lamella;--version")
  execute_process(COMMAND ${step} RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "${step} failed:\n${output}")
  endif()
endforeach()

if(NOT OPENVDB)
  return()
endif()
set(make_grid ${stage}/bin/lamella grid weave voxels=16 -o ${WORK}/weave.vdb)
execute_process(COMMAND ${make_grid} RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE error)
if(NOT status EQUAL 0)
  message(FATAL_ERROR "${make_grid} failed:\n${error}")
endif()
file(GLOB_RECURSE module ${stage}/${MODULE_DIR}/lamella_openvdb.so)
# Beside the program it is found as well.
file(RENAME ${module} ${stage}/bin/lamella_openvdb.so)
execute_process(COMMAND ${make_grid} RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE error)
if(NOT status EQUAL 0)
  message(FATAL_ERROR "${make_grid} with the module beside the program failed:\n${error}")
endif()
file(REMOVE ${stage}/bin/lamella_openvdb.so)
execute_process(COMMAND ${make_grid} RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE error)
if(NOT status EQUAL 2 OR NOT error MATCHES
   "^lamella: [^\n]*weave.vdb: the module for .vdb files cannot be loaded \\(lamella_openvdb.so: [^\n]*allowed: [^\n]*\n$")
  message(FATAL_ERROR "${make_grid} without the module: status ${status}\n${error}")
endif()
execute_process(COMMAND ${stage}/bin/lamella --version RESULT_VARIABLE status OUTPUT_QUIET)
if(NOT status EQUAL 0)
  message(FATAL_ERROR "the program does not start without the module of OpenVDB")
endif()
