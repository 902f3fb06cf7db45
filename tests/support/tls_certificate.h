// A certificate of a server that signs itself.
#ifndef CAIRN_TESTS_SUPPORT_TLS_CERTIFICATE_H_
#define CAIRN_TESTS_SUPPORT_TLS_CERTIFICATE_H_

#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/x509.h>
#include <openssl/x509v3.h>

#include <cstdio>
#include <stdexcept>
#include <string>

namespace cairn::testing {

struct TlsCertificateOptions {
  std::string host;
  int days_left = 1;  // Negative: it has expired.
};

class TlsCertificate {
 public:
  explicit TlsCertificate(const TlsCertificateOptions& options)
      : key_(EVP_EC_gen("P-256")), certificate_(X509_new()) {
    constexpr long kDay = 86'400;
    X509_set_version(certificate_, 2);
    ASN1_INTEGER_set(X509_get_serialNumber(certificate_), 1);
    X509_gmtime_adj(X509_getm_notBefore(certificate_), -10 * kDay);
    X509_gmtime_adj(X509_getm_notAfter(certificate_), options.days_left * kDay);
    X509_set_pubkey(certificate_, key_);
    X509_NAME* name = X509_get_subject_name(certificate_);
    X509_NAME_add_entry_by_txt(name, "CN", MBSTRING_ASC,
                               reinterpret_cast<const unsigned char*>(options.host.c_str()), -1, -1,
                               0);
    X509_set_issuer_name(certificate_, name);
    X509_EXTENSION* names = X509V3_EXT_conf_nid(nullptr, nullptr, NID_subject_alt_name,
                                                ("DNS:" + options.host).c_str());
    X509_add_ext(certificate_, names, -1);
    X509_EXTENSION_free(names);
    if (X509_sign(certificate_, key_, EVP_sha256()) == 0) {
      throw std::runtime_error("the certificate cannot be signed");
    }
  }
  ~TlsCertificate() {
    X509_free(certificate_);
    EVP_PKEY_free(key_);
  }
  TlsCertificate(const TlsCertificate&) = delete;
  TlsCertificate& operator=(const TlsCertificate&) = delete;

  X509* certificate() const { return certificate_; }
  EVP_PKEY* key() const { return key_; }

  void WriteTo(const std::string& pem_file) const {
    std::FILE* file = std::fopen(pem_file.c_str(), "w");
    if (file == nullptr || PEM_write_X509(file, certificate_) != 1 || std::fclose(file) != 0) {
      throw std::runtime_error("cannot write " + pem_file);
    }
  }

 private:
  EVP_PKEY* key_;
  X509* certificate_;
};

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_SUPPORT_TLS_CERTIFICATE_H_
