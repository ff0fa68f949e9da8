// INLINE marks functions whose call would take longer than their body.
#pragma once

#if defined(__GNUC__)
#define INLINE [[gnu::always_inline]] inline
#else
#define INLINE __forceinline
#endif
