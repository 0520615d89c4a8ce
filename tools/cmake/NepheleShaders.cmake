# nephele_embed_shaders(target files...): compiles each GLSL file to SPIR-V with glslang at build time and embeds it in
# the static library `target`. A shader `layer/resolve.comp` becomes `nephele::shaders::resolve_comp`, declared in the
# generated header `<target>.h`; no two shaders have the same file name. A line `// variants: NAME=DEFINE[,DEFINE] ...`
# in the source adds one embedded module per NAME, compiled with -DDEFINE (`nephele::shaders::shade_frag_NAME`).
function(nephele_embed_shaders target)
  set(out_dir ${PROJECT_BINARY_DIR}/generated/${target})
  file(MAKE_DIRECTORY ${out_dir})
  set(sources)
  set(declarations "")
  foreach(file ${ARGN})
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${file})
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
      set(header ${out_dir}/${module}.spv.h)
      set(source ${out_dir}/${module}.cpp)
      add_custom_command(OUTPUT ${header}
        COMMAND ${GLSLANG_VALIDATOR} --quiet -V --target-env vulkan1.3 -I${PROJECT_SOURCE_DIR}/shaders ${defines}
                --depfile ${header}.d --vn code -o ${header} ${file}
        DEPENDS ${file} DEPFILE ${header}.d VERBATIM COMMENT "glslang ${module}")
      file(CONFIGURE OUTPUT ${source} CONTENT
"#include \"@target@.h\"
#include <cstdint>
namespace {
#include \"@module@.spv.h\"
}
namespace nephele::shaders {
const ShaderCode @module@{\"@module@\", code, sizeof(code)};
}
" @ONLY)
      set_property(SOURCE ${source} APPEND PROPERTY OBJECT_DEPENDS ${header})
      list(APPEND sources ${source})
      string(APPEND declarations "extern const ShaderCode ${module};\n")
    endforeach()
  endforeach()
  file(CONFIGURE OUTPUT ${out_dir}/${target}.h CONTENT
"// Generated: shaders as SPIR-V.
#pragma once
#include \"engine/shader_code.h\"
namespace nephele::shaders {
@declarations@}
" @ONLY)
  add_library(${target} STATIC ${sources})
  target_compile_features(${target} PRIVATE cxx_std_20)
  target_include_directories(${target}
    PRIVATE $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
    PUBLIC $<BUILD_INTERFACE:${out_dir}> $<INSTALL_INTERFACE:include/nephele>)
endfunction()
