// The client side of TLS over bytes in memory: what comes and goes on a socket is up to the caller.
#ifndef CAIRN_HTTP_EXCHANGE_TLS_H_
#define CAIRN_HTTP_EXCHANGE_TLS_H_

#include <memory>
#include <string>
#include <string_view>

struct bio_st;
struct ssl_ctx_st;
struct ssl_st;

namespace cairn {

// Whom to trust. Shared by the sessions of one client.
class TlsContext {
 public:
  // Trusts the certificates of the system, or, if `ca_file` is not empty, those of this PEM file
  // alone. Throws Error(kIo) if the file cannot be read or holds no certificate.
  explicit TlsContext(const std::string& ca_file);
  ~TlsContext();

  ssl_ctx_st* get() const { return context_; }

 private:
  ssl_ctx_st* context_;
};

// One connection with TLS 1.2 or newer. Not thread-safe.
class TlsSession {
 public:
  enum class Step { kDone, kNeedsInput, kFailed };

  // The server must show a certificate for `host`, a name or an address. Throws Error(kInternal) if
  // OpenSSL has no memory.
  TlsSession(const TlsContext& context, const std::string& host);
  ~TlsSession();

  Step Handshake();
  // Reads decrypted bytes. kDone with 0 bytes: the server has ended the stream.
  Step Read(char* to, size_t size, size_t* num_read);
  // Encrypts `bytes`; TakeOutput has the result.
  bool Write(std::string_view bytes);

  void GiveInput(std::string_view encrypted);
  // Returns true if Read has not yet returned all that was given.
  bool HasInput() const;
  std::string TakeOutput();

  // Says why the last step has failed.
  std::string Explanation() const;

 private:
  Step StepOf(int result) const;

  ssl_st* session_;
  bio_st* input_;   // Owned by the session.
  bio_st* output_;  // Owned by the session.
  std::string host_;
};

}  // namespace cairn

#endif  // CAIRN_HTTP_EXCHANGE_TLS_H_
