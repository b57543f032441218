# A platform of PlatformIO that uses Debian's compilers. It replaces the platform of the registry on
# a machine without network. The variable DAVAR_PREFIX selects the compiler: empty for this machine,
# arm-none-eabi- for a Cortex-M4.
import os

from SCons.Script import AlwaysBuild, Default, DefaultEnvironment

env = DefaultEnvironment()
prefix = os.environ.get("DAVAR_PREFIX", "")
env.Replace(
    AR=prefix + "gcc-ar",
    CC=prefix + "gcc",
    RANLIB=prefix + "gcc-ranlib",
    LINK=prefix + "gcc",
    PROGSUFFIX=".elf",
)
env.Append(
    CCFLAGS=["-O2", "-ffunction-sections"],
    CFLAGS=["-std=c11"],
    LINKFLAGS=["-Wl,--gc-sections"],
    LIBS=["m"],
)
if prefix:
    core = ["-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"]
    env.Append(CCFLAGS=core, LINKFLAGS=[*core, "--specs=nosys.specs"])
program = env.BuildProgram()
AlwaysBuild(
    env.Alias("exec", program, env.VerboseAction("$BUILD_DIR/${PROGNAME}.elf", "Executing"))
)
Default(program)
