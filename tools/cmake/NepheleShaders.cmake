# nephele_embed_shaders(target files...): compiles each GLSL file to SPIR-V with glslang at build time and embeds it in
# the static library `target`. A shader `layer/resolve.comp` becomes `nephele::shaders::resolve_comp`, declared in the
# generated header `<target>.h`; no two shaders have the same file name. A line `// variants: NAME=DEFINE[,DEFINE] ...`
# in the source adds one embedded module per NAME, compiled with -DDEFINE (`nephele::shaders::shade_frag_NAME`). A
# shader that includes kit/texels.glsl is compiled once more for each module, with -DSTORAGE_TEXELS:
# ShaderCode::storage points to it. `nephele::shaders::all_of_<target>` lists every module.

# Sets `result` to whether a GLSL file includes kit/texels.glsl, itself or through what it includes.
function(nephele_reads_texels file result)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${file})
  set(${result} FALSE PARENT_SCOPE)
  file(STRINGS ${file} includes REGEX "^#include \"")
  foreach(include ${includes})
    string(REGEX REPLACE "^#include \"(.*)\".*" "\\1" name "${include}")
    if(name STREQUAL "kit/texels.glsl")
      set(${result} TRUE PARENT_SCOPE)
      return()
    endif()
    if(name MATCHES "\\.glsl$" AND EXISTS ${PROJECT_SOURCE_DIR}/shaders/${name})
      nephele_reads_texels(${PROJECT_SOURCE_DIR}/shaders/${name} inner)
      if(inner)
        set(${result} TRUE PARENT_SCOPE)
        return()
      endif()
    endif()
  endforeach()
endfunction()

function(nephele_embed_shaders target)
  set(out_dir ${PROJECT_BINARY_DIR}/generated/${target})
  file(MAKE_DIRECTORY ${out_dir})
  set(sources)
  set(declarations "")
  set(modules "")
  foreach(file ${ARGN})
    nephele_reads_texels(${file} reads_texels)
    get_filename_component(name ${file} NAME)
    string(REPLACE "." "_" symbol ${name})
    file(STRINGS ${file} variant_line REGEX "^// variants:" LIMIT_COUNT 1)
    string(REGEX REPLACE "^// variants:[ ]*" "" variants "${variant_line}")
    separate_arguments(variants)
    if(NOT variants)
      set(variants "-")
    endif()
    foreach(variant ${variants})
      set(module ${symbol})
      set(defines "")
      if(variant MATCHES "^([a-z0-9_]+)=?(.*)$")
        set(module ${symbol}_${CMAKE_MATCH_1})
        string(REPLACE "," ";" define_list "${CMAKE_MATCH_2}")
        foreach(define ${define_list})
          list(APPEND defines -D${define})
        endforeach()
      endif()
      set(source ${out_dir}/${module}.cpp)
      set(ways ${module})
      set(storage "nullptr")
      set(storage_code "")
      if(reads_texels)
        list(APPEND ways ${module}_storage)
        set(storage "&storage_module")
        set(storage_code "#include \"${module}_storage.spv.h\"
const nephele::ShaderCode storage_module{\"${module}_storage\", code_storage, sizeof(code_storage), nullptr};
")
      endif()
      foreach(way ${ways})
        set(header ${out_dir}/${way}.spv.h)
        set(way_defines ${defines})
        set(array code)
        if(way STREQUAL "${module}_storage")
          list(APPEND way_defines -DSTORAGE_TEXELS)
          set(array code_storage)
        endif()
        add_custom_command(OUTPUT ${header}
          COMMAND ${GLSLANG_VALIDATOR} --quiet -V --target-env vulkan1.3 -I${PROJECT_SOURCE_DIR}/shaders ${way_defines}
                  --depfile ${header}.d --vn ${array} -o ${header} ${file}
          DEPENDS ${file} DEPFILE ${header}.d VERBATIM COMMENT "glslang ${way}")
        set_property(SOURCE ${source} APPEND PROPERTY OBJECT_DEPENDS ${header})
      endforeach()
      file(CONFIGURE OUTPUT ${source} CONTENT
"#include \"@target@.h\"
#include <cstdint>
namespace {
#include \"@module@.spv.h\"
@storage_code@}
namespace nephele::shaders {
const ShaderCode @module@{\"@module@\", code, sizeof(code), @storage@};
}
" @ONLY)
      list(APPEND sources ${source})
      string(APPEND declarations "extern const ShaderCode ${module};\n")
      string(APPEND modules "\n    &${module},")
    endforeach()
  endforeach()
  file(CONFIGURE OUTPUT ${out_dir}/${target}.h CONTENT
"// Generated: shaders as SPIR-V.
#pragma once
#include \"engine/shader_code.h\"
namespace nephele::shaders {
@declarations@
inline const ShaderCode* const all_of_@target@[] = {@modules@
};
}
" @ONLY)
  add_library(${target} STATIC ${sources})
  target_compile_features(${target} PRIVATE cxx_std_20)
  target_include_directories(${target}
    PRIVATE $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
    PUBLIC $<BUILD_INTERFACE:${out_dir}> $<INSTALL_INTERFACE:include/nephele>)
endfunction()
