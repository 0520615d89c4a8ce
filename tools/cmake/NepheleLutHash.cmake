# nephele_lut_hash(target): a generated header lut_hash.h for the sources of `target`, with a hash of every file of this
# project that decides what a baked table contains. Cached tables carry the hash, so that a changed bake never meets an
# old file. The compiler names the files: those that lut/*_bake.cpp include, the .cpp files beside included headers,
# what these include, and so on. The hash is made anew in any build after one of the files has changed, and is the same
# in every checkout of the same files.
if(CMAKE_SCRIPT_MODE_FILE)
  # -DCOMPILER= -DFLAGS= -DINCLUDES= -DSOURCE_DIR= -DBINARY_DIR= -DROOTS= -DHEADER=; also writes ${HEADER}.d
  cmake_minimum_required(VERSION 3.25)
  list(TRANSFORM INCLUDES PREPEND -I)
  set(waiting ${ROOTS})
  set(files "")
  while(waiting)
    execute_process(COMMAND ${COMPILER} ${FLAGS} ${INCLUDES} -MM ${waiting}
      OUTPUT_VARIABLE rules RESULT_VARIABLE status ERROR_VARIABLE messages)
    if(NOT status EQUAL 0)
      message(FATAL_ERROR "The dependencies of the tables' sources could not be listed:\n${messages}")
    endif()
    # Make's syntax: "x.o: a.cpp b.h \", spaces in names as "\ ".
    string(ASCII 1 space)
    string(REPLACE "\\\n" " " rules "${rules}")
    string(REPLACE "\\ " "${space}" rules "${rules}")
    string(REGEX REPLACE "[^ \n]+\\.o:" "" rules "${rules}")
    string(REGEX MATCHALL "[^ \n]+" found "${rules}")
    list(TRANSFORM found REPLACE "${space}" " ")
    set(waiting "")
    foreach(file ${found})
      cmake_path(NORMAL_PATH file)
      cmake_path(IS_PREFIX SOURCE_DIR "${file}" ours)
      cmake_path(IS_PREFIX BINARY_DIR "${file}" built)
      if(NOT ours OR built OR file IN_LIST files)
        continue()
      endif()
      list(APPEND files ${file})
      string(REGEX REPLACE "\\.h$" ".cpp" beside ${file})
      if(file MATCHES "\\.h$" AND EXISTS ${beside} AND NOT beside IN_LIST files)
        list(APPEND waiting ${beside})
      endif()
    endforeach()
  endwhile()

  list(SORT files)
  set(digests "")
  set(names "")
  set(escaped "")
  foreach(file ${files})
    file(SHA256 ${file} digest)
    cmake_path(RELATIVE_PATH file BASE_DIRECTORY ${SOURCE_DIR} OUTPUT_VARIABLE name)
    string(APPEND digests "${digest} ${name}\n")
    string(APPEND names "//   ${name}\n")
    string(REPLACE " " "\\ " file "${file}")
    string(APPEND escaped " ${file}")
  endforeach()
  string(SHA256 hash "${digests}")
  string(SUBSTRING ${hash} 0 16 hash)
  file(CONFIGURE OUTPUT ${HEADER} CONTENT
"// Generated: the state of the files that decide what a baked table contains.
#pragma once

namespace nephele {
inline constexpr const char* kLutHash = \"@hash@\";
}  // namespace nephele

@names@" @ONLY)
  string(REPLACE " " "\\ " target "${HEADER}")
  file(WRITE ${HEADER}.d "${target}:${escaped}\n")
  return()
endif()

set(nephele_lut_hash_script ${CMAKE_CURRENT_LIST_FILE})
function(nephele_lut_hash target)
  file(GLOB roots CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/lut/*_bake.cpp)
  set(directory ${PROJECT_BINARY_DIR}/generated/${target})
  set(header ${directory}/lut_hash.h)
  separate_arguments(flags UNIX_COMMAND "${CMAKE_CXX_FLAGS}")
  add_custom_command(OUTPUT ${header}
    COMMAND ${CMAKE_COMMAND} -DCOMPILER=${CMAKE_CXX_COMPILER} "-DFLAGS=-std=c++20;${flags}"
            "-DINCLUDES=$<TARGET_PROPERTY:${target},INCLUDE_DIRECTORIES>" -DSOURCE_DIR=${PROJECT_SOURCE_DIR}
            -DBINARY_DIR=${PROJECT_BINARY_DIR} "-DROOTS=${roots}" -DHEADER=${header} -P ${nephele_lut_hash_script}
    DEPENDS ${roots} ${nephele_lut_hash_script} DEPFILE ${header}.d
    COMMENT "lut_hash.h" VERBATIM)
  target_sources(${target} PRIVATE ${header})
  target_include_directories(${target} PRIVATE ${directory})
endfunction()
