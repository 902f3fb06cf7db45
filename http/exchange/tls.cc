#include "http/exchange/tls.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <openssl/err.h>
#include <openssl/ssl.h>
#include <openssl/x509v3.h>

#include <algorithm>
#include <array>
#include <limits>

#include "core/error.h"

namespace cairn {
namespace {

std::string LastOpenSslError() {
  const unsigned long code = ERR_peek_last_error();
  const char* reason = code == 0 ? nullptr : ERR_reason_error_string(code);
  return reason == nullptr ? "unknown" : reason;
}

bool IsAddress(const std::string& host) {
  std::array<unsigned char, sizeof(in6_addr)> address;
  return inet_pton(AF_INET, host.c_str(), address.data()) == 1 ||
         inet_pton(AF_INET6, host.c_str(), address.data()) == 1;
}

int Length(std::string_view bytes) {
  return static_cast<int>(std::min<size_t>(bytes.size(), std::numeric_limits<int>::max()));
}

// Asks for the certificate of `host`, and accepts no other one.
bool ExpectHost(const std::string& host, SSL* session) {
  X509_VERIFY_PARAM* expected = SSL_get0_param(session);
  X509_VERIFY_PARAM_set_hostflags(expected, X509_CHECK_FLAG_NO_PARTIAL_WILDCARDS);
  if (IsAddress(host)) {
    return X509_VERIFY_PARAM_set1_ip_asc(expected, host.c_str()) == 1;
  }
  return X509_VERIFY_PARAM_set1_host(expected, host.c_str(), host.size()) == 1 &&
         SSL_set_tlsext_host_name(session, host.c_str()) == 1;
}

}  // namespace

TlsContext::TlsContext(const std::string& ca_file) : context_(SSL_CTX_new(TLS_client_method())) {
  if (context_ == nullptr) {
    throw Error(ErrorCode::kInternal, "OpenSSL does not start: " + LastOpenSslError());
  }
  SSL_CTX_set_min_proto_version(context_, TLS1_2_VERSION);
  SSL_CTX_set_verify(context_, SSL_VERIFY_PEER, nullptr);
  if (ca_file.empty()) {
    SSL_CTX_set_default_verify_paths(context_);
  } else if (SSL_CTX_load_verify_locations(context_, ca_file.c_str(), nullptr) != 1) {
    const std::string reason = LastOpenSslError();
    SSL_CTX_free(context_);
    throw Error(ErrorCode::kIo,
                fmt::format("{}: no certificates in PEM format can be read ({})", ca_file, reason));
  }
}

TlsContext::~TlsContext() { SSL_CTX_free(context_); }

TlsSession::TlsSession(const TlsContext& context, const std::string& host)
    : session_(SSL_new(context.get())),
      input_(BIO_new(BIO_s_mem())),
      output_(BIO_new(BIO_s_mem())),
      host_(host) {
  if (session_ == nullptr || input_ == nullptr || output_ == nullptr ||
      !ExpectHost(host, session_)) {
    BIO_free(input_);
    BIO_free(output_);
    SSL_free(session_);
    throw Error(ErrorCode::kInternal, "OpenSSL makes no session: " + LastOpenSslError());
  }
  BIO_set_mem_eof_return(input_, -1);  // An empty input is not the end of the stream.
  SSL_set_bio(session_, input_, output_);
  SSL_set_connect_state(session_);
}

TlsSession::~TlsSession() { SSL_free(session_); }

TlsSession::Step TlsSession::StepOf(int result) const {
  if (result > 0) {
    return Step::kDone;
  }
  return SSL_get_error(session_, result) == SSL_ERROR_WANT_READ ? Step::kNeedsInput : Step::kFailed;
}

TlsSession::Step TlsSession::Handshake() {
  ERR_clear_error();
  return StepOf(SSL_do_handshake(session_));
}

TlsSession::Step TlsSession::Read(char* to, size_t size, size_t* num_read) {
  ERR_clear_error();
  *num_read = 0;
  const int result = SSL_read(session_, to, Length({to, size}));
  if (result > 0) {
    *num_read = static_cast<size_t>(result);
  } else if (SSL_get_error(session_, result) == SSL_ERROR_ZERO_RETURN) {
    return Step::kDone;
  }
  return StepOf(result);
}

bool TlsSession::Write(std::string_view bytes) {
  while (!bytes.empty()) {
    ERR_clear_error();
    const int result = SSL_write(session_, bytes.data(), Length(bytes));
    if (result <= 0) {
      return false;
    }
    bytes.remove_prefix(static_cast<size_t>(result));
  }
  return true;
}

void TlsSession::GiveInput(std::string_view encrypted) {
  BIO_write(input_, encrypted.data(), Length(encrypted));
}

bool TlsSession::HasInput() const {
  return SSL_pending(session_) > 0 || BIO_ctrl_pending(input_) > 0;
}

std::string TlsSession::TakeOutput() {
  std::string output(BIO_ctrl_pending(output_), '\0');
  if (!output.empty()) {
    BIO_read(output_, output.data(), Length(output));
  }
  return output;
}

std::string TlsSession::Explanation() const {
  const long verdict = SSL_get_verify_result(session_);
  if (verdict != X509_V_OK) {
    return fmt::format("the certificate of {} is not accepted: {}", host_,
                       X509_verify_cert_error_string(verdict));
  }
  return fmt::format("TLS with {} failed: {}", host_, LastOpenSslError());
}

}  // namespace cairn
