/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Parses XML documents by expat, which is loaded when one is met. A document that declares its
 * type, and so could declare entities, is refused. */
#include <hooke/base/library.h>
#include "modules/recording/container/container.h"

#include <string.h>

const char *xml_attribute(const char **attributes, const char *name)
{
    for (; attributes[0]; attributes += 2)
        if (strcmp(attributes[0], name) == 0)
            return attributes[1];
    return NULL;
}

#ifdef HAVE_EXPAT
#include <expat.h>

#define EXPAT_LIBRARY "libexpat.so.1"
#define PIECE_BYTES (1u << 20) /* [byte] parsed at once */
#define TOKEN_MAX (8u << 20)   /* [byte] longest name or attribute */
#define DEPTH_MAX 200          /* depth of nested elements; an instrument has fewer than twenty */

#define EXPAT_FUNCTIONS(X)                                                                         \
    X(XML_ParserCreate)                                                                            \
    X(XML_ParserFree)                                                                              \
    X(XML_SetUserData)                                                                             \
    X(XML_SetElementHandler)                                                                       \
    X(XML_SetCharacterDataHandler)                                                                 \
    X(XML_SetStartDoctypeDeclHandler)                                                              \
    X(XML_StopParser)                                                                              \
    X(XML_Parse)                                                                                   \
    X(XML_GetErrorCode)                                                                            \
    X(XML_ErrorString)                                                                             \
    X(XML_GetCurrentLineNumber)

/* The loaded library and its functions. */
struct expat_api {
#define MEMBER(name) __typeof__(name) *name;
    EXPAT_FUNCTIONS(MEMBER)
#undef MEMBER
    struct library library;
};

/* Loads expat. Returns false with the error and a hint if it is not installed. */
static bool load_expat_library(struct expat_api *api, const char *shown, struct error *error)
{
    static const struct library_symbol functions[] = {
#define SYMBOL(name) {#name, offsetof(struct expat_api, name)},
        EXPAT_FUNCTIONS(SYMBOL)
#undef SYMBOL
    };
    const char *missing;
    if (library_load(&api->library, EXPAT_LIBRARY, functions, COUNT_OF(functions), api, &missing))
        return true;
    error_set(error, ERROR_IO, "%s is an XML document, which expat reads, but %s cannot be loaded",
              shown, EXPAT_LIBRARY);
    return error_hint(error, "install libexpat1, or export the data as CSV");
}

/* A document that is being parsed, the context of expat's handlers. */
struct parsing {
    struct expat_api api;
    XML_Parser parser;
    const struct xml_reader *reader;
    int depth;
    size_t events;       /* elements and pieces of text so far */
    bool stopped, typed; /* a handler ended it; it declares its document type */
};

/* Ends the parsing; expat may still call handlers, which then do nothing. */
static void parsing_stop(struct parsing *p)
{
    p->stopped = true;
    p->api.XML_StopParser(p->parser, XML_FALSE);
}

/* Passes the start of an element to the reader, unless it is nested too deeply. */
static void on_start(void *data, const XML_Char *name, const XML_Char **attributes)
{
    struct parsing *p = data;
    p->events++;
    if (!p->stopped &&
        (++p->depth > DEPTH_MAX || !p->reader->start(p->reader->context, name, attributes)))
        parsing_stop(p);
}

/* Passes the end of an element to the reader. */
static void on_end(void *data, const XML_Char *name)
{
    struct parsing *p = data;
    p->events++;
    p->depth -= !p->stopped;
    if (!p->stopped && !p->reader->end(p->reader->context, name))
        parsing_stop(p);
}

/* Passes text to the reader. */
static void on_text(void *data, const XML_Char *text, int len)
{
    struct parsing *p = data;
    p->events++;
    if (!p->stopped && !p->reader->text(p->reader->context, (struct text){text, (size_t)len}))
        parsing_stop(p);
}

/* Refuses a document type declaration. */
static void on_type(void *data, const XML_Char *name, const XML_Char *system,
                    const XML_Char *public, int internal)
{
    struct parsing *p = data;
    (void)name, (void)system, (void)public, (void)internal;
    p->typed = true;
    parsing_stop(p);
}

/* Parses the document piece by piece. Returns false with the error if it is invalid, suspicious or
 * cancelled. */
static bool parse(struct parsing *p, struct text document, const char *shown, struct error *error)
{
    bool done = true;
    size_t events = 0, silent_bytes = 0; /* silent_bytes: [byte] since the last event */
    for (size_t offset = 0; done && offset <= document.len; offset += PIECE_BYTES) {
        const size_t len =
            document.len - offset < PIECE_BYTES ? document.len - offset : PIECE_BYTES;
        silent_bytes = p->events > events ? 0 : silent_bytes + len;
        events = p->events;
        if (silent_bytes > TOKEN_MAX)
            return error_set(
                error, ERROR_IO,
                "refused: %s contains a name of more than %u bytes, which no instrument writes",
                shown, TOKEN_MAX);
        if (!unpacking_goes_on(p->reader->cancel, error))
            return false;
        done = p->api.XML_Parse(p->parser, document.data + offset, (int)len,
                                offset + len == document.len) == XML_STATUS_OK;
        if (offset + len == document.len)
            break;
    }
    if (p->typed || p->depth > DEPTH_MAX) {
        error_set(error, ERROR_IO, "refused: %s %s, which no instrument does", shown,
                  p->typed ? "declares its document type, as for XML entities"
                           : "nests XML elements without end");
        return error_hint(error, "export the data as CSV");
    }
    if (!done && !p->stopped) {
        error_set(error, ERROR_IO, "%s is not valid XML: %s in line %lu", shown,
                  p->api.XML_ErrorString(p->api.XML_GetErrorCode(p->parser)),
                  (unsigned long)p->api.XML_GetCurrentLineNumber(p->parser));
        return error_hint(error, "transfer the file again, or export the data as CSV");
    }
    return done && !p->stopped;
}

/* Loads expat and parses the document with the reader's handlers. */
bool xml_read(struct text document, const char *shown, const struct xml_reader *reader,
              struct error *error)
{
    struct parsing p = {.reader = reader};
    if (!load_expat_library(&p.api, shown, error))
        return false;
    p.parser = p.api.XML_ParserCreate(NULL);
    bool done = p.parser || error_memory(error);
    if (done) {
        p.api.XML_SetUserData(p.parser, &p);
        p.api.XML_SetElementHandler(p.parser, on_start, on_end);
        p.api.XML_SetCharacterDataHandler(p.parser, on_text);
        p.api.XML_SetStartDoctypeDeclHandler(p.parser, on_type);
        done = parse(&p, document, shown, error);
        p.api.XML_ParserFree(p.parser);
    }
    library_unload(&p.api.library);
    return done;
}
#else
/* Loads expat and parses the document with the reader's handlers, which can stop it with an error
 * of their own. `shown` is the name for messages. Returns false with the error. */
bool xml_read(struct text document, const char *shown, const struct xml_reader *reader,
              struct error *error)
{
    (void)document, (void)reader;
    error_set(error, ERROR_IO, "%s is an XML document, and this hooke was built without expat",
              shown);
    return error_hint(error, "install libexpat1-dev and build it again, or export the data as CSV");
}
#endif
