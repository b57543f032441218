# Toolchain of the targets with Linux; DAVAR_TARGET selects one. Programs are static, so the emulator
# needs no libraries of the target.
set(CMAKE_SYSTEM_NAME Linux)
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES DAVAR_TARGET)
include("${CMAKE_CURRENT_LIST_DIR}/board.cmake")
board_field(toolchain toolchain)
board_field(cpu cpu)
set(CMAKE_C_COMPILER ${toolchain}gcc)
set(CMAKE_C_FLAGS_INIT "${cpu} -ffunction-sections -fdata-sections")
set(CMAKE_EXE_LINKER_FLAGS_INIT "-static")
