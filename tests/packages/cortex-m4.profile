# Conan: a Cortex-M4 with Debian's compiler. The arch is only a name, because Conan has none for a Cortex-M.
[settings]
os=baremetal
arch=armv7hf
compiler=gcc
compiler.version=12
compiler.libcxx=libstdc++11
build_type=Release
[conf]
tools.build:compiler_executables={"c": "arm-none-eabi-gcc"}
tools.build:cflags=["-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"]
tools.build:exelinkflags=["--specs=nano.specs", "--specs=nosys.specs"]
tools.cmake.cmaketoolchain:extra_variables={"CMAKE_TRY_COMPILE_TARGET_TYPE": "STATIC_LIBRARY", "CMAKE_SYSTEM_NAME": "Generic"}
