# davar_own_code: compiles davar's own sources. Private to this build; users do not inherit it.
# No contraction and no x87, because floating-point results must have the same bits on every target.
# No errno, so that a square root is one instruction without a library call, where the target has it.
include(CheckCSourceCompiles)

add_library(davar_own_code INTERFACE)

if(CMAKE_C_COMPILER_ID MATCHES "GNU|Clang")
  target_compile_options(
    davar_own_code
    INTERFACE -ffp-contract=off
              -fno-math-errno
              -Wall
              -Wextra
              -Wpedantic
              -Wconversion
              -Wsign-conversion
              -Wdouble-promotion
              -Wshadow
              -Wundef
              -Wswitch-enum
              -Wfloat-equal
              -Wcast-align
              -Wmissing-prototypes
              -Wstrict-prototypes
              -Wvla
              $<$<BOOL:${DAVAR_WERROR}>:-Werror>)
  check_c_source_compiles("#ifndef __i386__\n#error not x86 with 32 bits\n#endif\nint main(void){return 0;}"
                          DAVAR_IS_X86_32)
  if(DAVAR_IS_X86_32)
    target_compile_options(davar_own_code INTERFACE -msse2 -mfpmath=sse)
  endif()
endif()
