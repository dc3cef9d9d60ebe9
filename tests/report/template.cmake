# The template that is kept must be what its sources and the locked packages give.
file(REMOVE_RECURSE ${FOLDER}/source)
file(COPY ${SOURCE}/build.mjs ${SOURCE}/source DESTINATION ${FOLDER})
execute_process(COMMAND ${NODE} build.mjs page.html WORKING_DIRECTORY ${FOLDER}
                COMMAND_ERROR_IS_FATAL ANY)
file(SHA256 ${FOLDER}/page.html made)
file(SHA256 ${SOURCE}/page.html kept)
if(NOT made STREQUAL kept)
  message(FATAL_ERROR "compare/report/page/page.html is not what its sources give: run "
                      "npm ci && npm run build in compare/report/page and commit it")
endif()
