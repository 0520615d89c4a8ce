# nephele_commit(target): a header commit.h with the commit the sources are from, renewed at every build and touched
# only when it changes. "-changed" where files differ from the commit; "unknown" outside a git checkout.
if(CMAKE_SCRIPT_MODE_FILE)
  cmake_minimum_required(VERSION 3.25)
  execute_process(COMMAND git describe --always --dirty=-changed --abbrev=10 --exclude=*
    WORKING_DIRECTORY ${SOURCE_DIR} OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  if(NOT commit)
    set(commit unknown)
  endif()
  file(CONFIGURE OUTPUT ${HEADER} CONTENT
"#pragma once\n\ninline constexpr const char* kCommit = \"@commit@\";\n" @ONLY)
  return()
endif()

set(nephele_commit_script ${CMAKE_CURRENT_LIST_FILE})
function(nephele_commit target)
  set(header ${PROJECT_BINARY_DIR}/generated/${target}/commit.h)
  add_custom_target(${target}_commit
    COMMAND ${CMAKE_COMMAND} -DSOURCE_DIR=${PROJECT_SOURCE_DIR} -DHEADER=${header} -P ${nephele_commit_script}
    BYPRODUCTS ${header} COMMENT "" VERBATIM)
  add_dependencies(${target} ${target}_commit)
  target_include_directories(${target} PRIVATE ${PROJECT_BINARY_DIR}/generated/${target})
endfunction()
