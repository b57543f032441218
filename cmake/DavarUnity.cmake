# unity: the test framework; it is never installed. Its source is DAVAR_UNITY_DIR if set (tools/test
# sets it), otherwise upstream.
set(DAVAR_UNITY_DIR "" CACHE PATH "Folder with unity.c, unity.h and unity_internals.h; empty: fetch Unity")

if(DAVAR_UNITY_DIR)
  set(unity_dir "${DAVAR_UNITY_DIR}")
else()
  include(FetchContent)
  # SOURCE_SUBDIR has no CMakeLists.txt, so the sources are fetched but Unity's own build does not run.
  FetchContent_Declare(unity_upstream GIT_REPOSITORY https://github.com/ThrowTheSwitch/Unity.git GIT_TAG v2.6.0
                       GIT_SHALLOW ON SOURCE_SUBDIR src)
  FetchContent_MakeAvailable(unity_upstream)
  set(unity_dir "${unity_upstream_SOURCE_DIR}/src")
endif()

add_library(unity STATIC "${unity_dir}/unity.c")
target_include_directories(unity SYSTEM PUBLIC "${unity_dir}")
target_compile_definitions(unity PUBLIC UNITY_INCLUDE_DOUBLE UNITY_SUPPORT_64)
