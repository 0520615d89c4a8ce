# The renderer as a package: find_package(nephele) gives the target nephele::nephele, the public headers and, if it was
# built, the program. Public are passes/nephele.h and the headers that it includes, directly or through others; the
# install step itself follows the includes, so that no list goes stale.
include(CMakePackageConfigHelpers)

set_target_properties(nephele_renderer PROPERTIES EXPORT_NAME nephele)
install(TARGETS nephele_options nephele_shaders nephele_engine nephele_lut nephele_renderer EXPORT nephele
  ARCHIVE DESTINATION lib)
if(NEPHELE_PROGRAM)
  install(TARGETS nephele_program RUNTIME DESTINATION bin)
endif()
install(CODE "set(NEPHELE_SOURCE_DIR \"${PROJECT_SOURCE_DIR}\")")
install(SCRIPT tools/cmake/NephelePublicHeaders.cmake)
install(EXPORT nephele NAMESPACE nephele:: FILE nepheleTargets.cmake DESTINATION lib/cmake/nephele)

write_basic_package_version_file(${PROJECT_BINARY_DIR}/nepheleConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES tools/cmake/nepheleConfig.cmake ${PROJECT_BINARY_DIR}/nepheleConfigVersion.cmake
  DESTINATION lib/cmake/nephele)
