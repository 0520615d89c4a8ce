# The renderer as a package: find_package(nephele) gives the target nephele::nephele, its headers and the program.
include(CMakePackageConfigHelpers)

set_target_properties(nephele_renderer PROPERTIES EXPORT_NAME nephele)
install(TARGETS nephele_options nephele_shaders nephele_engine nephele_lut nephele_renderer
  EXPORT nephele ARCHIVE DESTINATION lib)
install(TARGETS nephele_program RUNTIME DESTINATION bin)
install(DIRECTORY engine passes lut DESTINATION include/nephele FILES_MATCHING PATTERN "*.h")
install(DIRECTORY shaders/shared DESTINATION include/nephele FILES_MATCHING PATTERN "*.h")
install(FILES ${PROJECT_BINARY_DIR}/generated/nephele_shaders/nephele_shaders.h DESTINATION include/nephele)
install(EXPORT nephele NAMESPACE nephele:: FILE nepheleTargets.cmake DESTINATION lib/cmake/nephele)

write_basic_package_version_file(${PROJECT_BINARY_DIR}/nepheleConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES tools/cmake/nepheleConfig.cmake ${PROJECT_BINARY_DIR}/nepheleConfigVersion.cmake
  DESTINATION lib/cmake/nephele)
