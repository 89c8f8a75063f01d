/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Names of a scene that a program cannot have: words of its language, functions of its library, and
 * what programs use themselves. */
#include "modules/programs/program.h"

#include <ctype.h>
#include <string.h>

/* of variables and functions of programs */
static const char of_programs[] =
    " bend change choose control damping derivative derivatives double dt error error_most "
    "error_order first fixed friction_most good h half i inside int interval inverse jacobian "
    "keep last limited long lost main moment more now number pi power pull quadratic round_half "
    "row rows size slopes solve square state step steps stiffness t0 t_end tol total turn v_free "
    "v_new weight weight_inside weight_low ";

/* of C and of the headers that programs include; of functions of numbers without the f and l behind
 */
static const char of_c[] =
    " BUFSIZ EOF FILE HUGE_VAL HUGE_VALF HUGE_VALL INFINITY L_ctermid L_tmpnam MATH_ERREXCEPT "
    "MATH_ERRNO NAN NULL P_tmpdir acos acosh asin asinh asm atan atan2 atanh auto bcmp bcopy bool "
    "break bzero case cbrt ceil char clearerr const continue copysign cos cosh ctermid default "
    "div do double dprintf drem else enum erf erfc exp exp10 exp2 explicit_bzero expm1 extern "
    "fabs false fclose fdim fdopen feof ferror fflush ffs fgetc fgetpos fgets fileno finite float "
    "flockfile floor fma fmax fmemopen fmin fmod fopen for fprintf fputc fputs fread freopen "
    "frexp fscanf fseek fseeko fsetpos ftell ftello ftrylockfile funlockfile fwrite gammaf gammal "
    "getc getchar getdelim getline getw goto hypot if ilogb inline int isinf isnan j0f j0l j1f "
    "j1l jnf jnl ldexp lgamma linux llrint llround log log10 log1p log2 logb long lrint lround "
    "math_errhandling memccpy memchr memcmp memcpy memmove memset modf nan nearbyint nextafter "
    "nexttoward open_memstream pclose perror popen pow pow10 printf putc putchar puts putw "
    "register remainder remove remquo rename renameat restrict return rewind rindex rint round "
    "scalb scalbln scalbn scanf setbuf setbuffer setlinebuf setvbuf short signed significand sin "
    "sinh sizeof snprintf sprintf sqrt sscanf static stderr stdin stdout stpcpy stpncpy "
    "strcasecmp strcat strchr strcmp strcoll strcpy strcspn strdup strerror strlen strncasecmp "
    "strncat strncmp strncpy strndup strnlen strpbrk strrchr strsep strsignal strspn strstr "
    "strtok struct strxfrm switch tan tanh tempnam tgamma tmpfile tmpnam true trunc typedef "
    "typeof ungetc union unix unsigned va_list vdprintf vfprintf vfscanf void volatile vprintf "
    "vscanf vsnprintf vsprintf vsscanf while y0f y0l y1f y1l ynf ynl ";

/* of Python, and what programs call */
static const char of_python[] =
    " Adaptive False None True abs all and as assert async await bin break class continue copysign "
    "def "
    "del elif eliminate else enumerate except expm1 finally float for frexp from global if import "
    "in int is log2_near exp2_near atan_near OverflowError ValueError "
    "isfinite lambda len list max min nonlocal not or pass plt print raise range return reversed "
    "round self str sum super sys try ulp while with yield zip ";

/* of Octave and MATLAB */
static const char of_octave[] =
    " __FILE__ __LINE__ abs acos asin atan atan2 break case catch ceil classdef continue cos cosh "
    "do else elseif end end_try_catch end_unwind_protect endclassdef endenumeration endevents "
    "endfor endfunction endif endmethods endparfor endproperties endswitch endwhile enumeration "
    "events exp expm1 floor for function global hypot if import log log10 max methods min mod "
    "nthroot ode45 odeset otherwise parfor persistent printf properties return round sign sin "
    "sinh spmd sqrt switch tan tanh try until unwind_protect unwind_protect_cleanup warning while "
    "zeros ";

/* Functions of C that parameters are often called as: constants behind a macro, so that formulas
 * have their own names. */
static const char shadows[] = " gamma index j0 j1 jn signgam y0 y1 yn ";

/* What such words are, or begin with before a number or an underscore; what they end with. */
static const char *const begins[] = {"acceleration", "adaptive", "drag",  "fixed",
                                     "force",        "function", "part",  "propagate",
                                     "slope",        "solve",    "stage", "turning"};
static const char *const ends[] = {"_new", "_t", "_r", "_l", "_MAX", "_MIN", "_unlocked"};
static const char *const macros[] = {"M_", "FP_", "SEEK_"};

static bool among(const char *words, const char *name, size_t len)
{
    for (const char *at = words; (at = strchr(at, ' ')) && at[1]; at++)
        if (strncmp(at + 1, name, len) == 0 && at[1 + len] == ' ')
            return true;
    return false;
}

/* "y_at2" */
static bool is_stage(const char *name)
{
    const char *at = strstr(name, "_at");
    return at && isdigit((unsigned char)at[3]);
}

bool program_shadows(const char *name)
{
    return among(shadows, name, strlen(name));
}

bool program_takes(enum dialect dialect, const char *name)
{
    const char *words = dialect == DIALECT_PYTHON   ? of_python
                        : dialect == DIALECT_OCTAVE ? of_octave
                                                    : of_c;
    const size_t len = strlen(name);
    if (among(of_programs, name, len) || among(words, name, len) || is_stage(name))
        return true;
    for (size_t i = 0; i < COUNT_OF(begins); i++) {
        const size_t part = strlen(begins[i]);
        const char behind = strncmp(name, begins[i], part) == 0 ? name[part] : 'x';
        if (behind == '\0' || behind == '_' || isdigit((unsigned char)behind))
            return true;
    }
    for (size_t i = 0; i < COUNT_OF(ends); i++)
        if (len > strlen(ends[i]) && strcmp(name + len - strlen(ends[i]), ends[i]) == 0)
            return true;
    for (size_t i = 0; i < COUNT_OF(macros); i++)
        if (strncmp(name, macros[i], strlen(macros[i])) == 0)
            return true;
    return dialect == DIALECT_C && len > 2 && strchr("fl", name[len - 1]) &&
           among(of_c, name, len - 1);
}
