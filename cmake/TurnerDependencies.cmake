# The libraries that Turner stands on, all from Debian packages (cmake/setup.sh installs them).
find_package(PkgConfig REQUIRED)
find_package(Threads REQUIRED)
find_package(Vulkan REQUIRED)
find_package(glslang CONFIG REQUIRED)
find_package(SPIRV-Tools CONFIG REQUIRED)
find_package(SPIRV-Tools-opt CONFIG REQUIRED)
find_package(glm REQUIRED)
find_package(OpenEXR CONFIG REQUIRED)
find_package(PNG REQUIRED)
find_package(fmt CONFIG REQUIRED)
find_package(embree NAMES embree embree-4 embree-3 CONFIG QUIET)
if(NOT embree_FOUND)
  # Debian's package keeps its configuration in a folder with the full version.
  file(GLOB embree_folder /usr/lib/*/cmake/embree-*)
  find_package(embree CONFIG REQUIRED PATHS ${embree_folder} NO_DEFAULT_PATH)
endif()
pkg_check_modules(GEOS REQUIRED IMPORTED_TARGET geos)
pkg_check_modules(NETTLE REQUIRED IMPORTED_TARGET nettle)
find_path(RAPIDJSON_INCLUDE_DIR rapidjson/reader.h REQUIRED)
find_path(CLI11_INCLUDE_DIR CLI/CLI.hpp REQUIRED)

add_library(turner_dependencies INTERFACE)
target_include_directories(turner_dependencies SYSTEM INTERFACE ${RAPIDJSON_INCLUDE_DIR} ${CLI11_INCLUDE_DIR})
target_link_libraries(turner_dependencies INTERFACE
  Threads::Threads Vulkan::Vulkan glslang::glslang glslang::SPIRV glslang::glslang-default-resource-limits
  SPIRV-Tools-opt glm::glm OpenEXR::OpenEXR PNG::PNG fmt::fmt embree PkgConfig::GEOS PkgConfig::NETTLE)
