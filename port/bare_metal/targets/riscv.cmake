# Toolchain of the RISC-V targets; DAVAR_TARGET selects one.
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_SYSTEM_PROCESSOR riscv)
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES DAVAR_TARGET)
include("${CMAKE_CURRENT_LIST_DIR}/board.cmake")
board_field(toolchain toolchain)
board_field(cpu cpu)
set(CMAKE_C_COMPILER ${toolchain}gcc)
set(CMAKE_C_FLAGS_INIT
    "${cpu} -mcmodel=medany --specs=picolibc.specs -ffunction-sections -fdata-sections")
